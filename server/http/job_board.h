#pragma once
/// JobBoard: requests that are answered in the background, and their answers until they are fetched.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "server/http/exchange.h"
#include "server/http/request_memory.h"

namespace sightline {

/// Limits of a JobBoard.
struct JobLimits {
  std::size_t threads = 2;       ///< jobs that run at once
  std::size_t jobs = 64;         ///< jobs in all states
  std::size_t jobs_of_key = 32;  ///< of one key, if keys are in use
  /// bytes of bodies that wait, and of answers; answers that do not fit fail
  std::uint64_t bytes = std::uint64_t{64} << 20;
  std::chrono::seconds kept{600};  ///< time from the end of a job until it is forgotten
};

/// A background request: the state that others may read.
struct JobReport {
  enum class State { kQueued, kRunning, kDone };
  State state = State::kQueued;
  std::string target;                         ///< of the request
  std::uint64_t pieces_done = 0, pieces = 0;  ///< WorkProgress
  int status = 0;                             ///< of the answer, if kDone
  std::uint64_t bytes = 0;                    ///< of the answer, if kDone
  std::chrono::seconds kept{0};               ///< until the job is forgotten, if kDone
};

/// Runs jobs on threads of its own, in the order of arrival. A job is known by a random id of 128
/// bits, and only to requests with the key that it was made with. Ended jobs are forgotten after
/// JobLimits::kept. Bytes that wait are charged to the budget of requests, and a running job
/// reserves memory as any request does. All functions are thread-safe.
class JobBoard {
 public:
  using Answer = std::function<void(Exchange&)>;
  /// answer  answers a request whose body is Exchange::whole_body; called on the job's thread
  /// budget  of the server's requests; both must outlive the object
  JobBoard(const JobLimits& limits, MemoryBudget& budget, Answer answer);
  /// Cancels all jobs, and waits for those that run.
  ~JobBoard();
  JobBoard(const JobBoard&) = delete;
  JobBoard& operator=(const JobBoard&) = delete;

  /// Queues a request with its whole body, and returns the job's id. Errors: JOBS_FULL.
  Result<std::string> add(const RequestHead& head, std::string body, std::string request_id);
  /// What is known of a job; empty if this key has no such job.
  std::optional<JobReport> find(const std::string& id, const std::string& key_name);
  /// The answer of a job in state kDone; null otherwise.
  std::shared_ptr<const HttpResponse> answer_of(const std::string& id, const std::string& key_name);
  /// Cancels a job and forgets it. False if this key has no such job.
  bool remove(const std::string& id, const std::string& key_name);
  const JobLimits& limits() const { return limits_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    RequestHead head;
    std::string body, request_id;
    JobReport::State state = JobReport::State::kQueued;
    WorkProgress progress;
    CancelFlag cancel;
    std::shared_ptr<HttpResponse> response = std::make_shared<HttpResponse>();
    std::uint64_t bytes = 0;   ///< charged
    std::uint64_t number = 0;  ///< order of arrival
    Clock::time_point ended;
  };
  using Jobs = std::map<std::string, std::shared_ptr<Job>>;

  void run();
  void run_job(Job& job);
  /// Charges or releases bytes of a job. Precondition: mutex_ is held.
  bool charge(Job& job, std::uint64_t bytes);
  void forget_old();
  std::shared_ptr<Job> next();
  Jobs::iterator find_job(const std::string& id, const std::string& key_name);

  const JobLimits limits_;
  MemoryBudget& budget_;
  const Answer answer_;
  std::mutex mutex_;
  std::condition_variable wake_;
  Jobs jobs_;
  std::uint64_t bytes_ = 0, arrivals_ = 0;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace sightline

// Tests: tests/integration/jobs_test.py
