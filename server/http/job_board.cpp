#include "server/http/job_board.h"

#include <sys/random.h>

#include <array>
#include <utility>

#include "core/base/priority.h"

namespace sightline {
namespace {

std::optional<std::string> random_id() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return {};
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id;
  for (const unsigned char byte : bytes) {
    id += kDigits[byte >> 4];
    id += kDigits[byte & 15];
  }
  return id;
}

std::uint64_t bytes_of(const HttpResponse& response) {
  std::uint64_t bytes = response.body.capacity();
  for (const auto& [name, value] : response.headers) bytes += name.size() + value.size();
  return bytes;
}

/// The error of a job that does not fit.
Error jobs_full(std::string message) {
  return {ErrorKind::kBusy, "JOBS_FULL", std::move(message), ""};
}

}  // namespace

JobBoard::JobBoard(const JobLimits& limits, MemoryBudget& budget, Answer answer)
    : limits_(limits), budget_(budget), answer_(std::move(answer)) {
  for (std::size_t i = 0; i < limits_.threads; ++i) threads_.emplace_back([this] { run(); });
}

JobBoard::~JobBoard() {
  {
    const std::lock_guard hold(mutex_);
    ending_ = true;
    for (const auto& [id, job] : jobs_) job->cancel.cancel();
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  budget_.release(bytes_);
}

bool JobBoard::charge(Job& job, std::uint64_t bytes) {
  if (bytes > job.bytes) {
    const std::uint64_t more = bytes - job.bytes;
    if (more > limits_.bytes - bytes_ || !budget_.charge(more)) return false;
    bytes_ += more;
  } else {
    budget_.release(job.bytes - bytes);
    bytes_ -= job.bytes - bytes;
  }
  job.bytes = bytes;
  return true;
}

void JobBoard::forget_old() {
  const auto now = Clock::now();
  for (auto each = jobs_.begin(); each != jobs_.end();) {
    Job& job = *each->second;
    if (job.state != JobReport::State::kDone || now - job.ended < limits_.kept) {
      ++each;
      continue;
    }
    charge(job, 0);
    each = jobs_.erase(each);
  }
}

Result<std::string> JobBoard::add(const RequestHead& head, std::string body,
                                  std::string request_id) {
  auto id = random_id();
  if (!id) return Error{ErrorKind::kInternal, "INTERNAL", "the system has no random bytes", ""};
  auto job = std::make_shared<Job>();
  job->head = head;
  job->body = std::move(body);
  job->request_id = std::move(request_id);
  const std::lock_guard hold(mutex_);
  forget_old();
  std::size_t of_key = 0;
  for (const auto& [known, other] : jobs_)
    of_key += other->head.key_name == head.key_name ? 1u : 0u;
  if (jobs_.size() >= limits_.jobs || (!head.key_name.empty() && of_key >= limits_.jobs_of_key)) {
    return jobs_full("there are " + std::to_string(jobs_.size()) +
                     " jobs: fetch their answers and DELETE them");
  }
  if (!charge(*job, job->body.capacity()))
    return jobs_full("bodies and answers of other jobs have the memory: DELETE jobs");
  job->number = arrivals_++;
  jobs_.emplace(*id, std::move(job));
  wake_.notify_one();
  return std::move(*id);
}

JobBoard::Jobs::iterator JobBoard::find_job(const std::string& id, const std::string& key_name) {
  forget_old();
  const auto found = jobs_.find(id);
  return found != jobs_.end() && found->second->head.key_name == key_name ? found : jobs_.end();
}

std::optional<JobReport> JobBoard::find(const std::string& id, const std::string& key_name) {
  const std::lock_guard hold(mutex_);
  const auto found = find_job(id, key_name);
  if (found == jobs_.end()) return std::nullopt;
  const Job& job = *found->second;
  JobReport report{job.state, job.head.target, job.progress.done, job.progress.all};
  if (job.state == JobReport::State::kDone) {
    report.status = job.response->status;
    report.bytes = job.response->body.size();
    report.kept =
        std::chrono::ceil<std::chrono::seconds>(limits_.kept - (Clock::now() - job.ended));
  }
  return report;
}

std::shared_ptr<const HttpResponse> JobBoard::answer_of(const std::string& id,
                                                        const std::string& key_name) {
  const std::lock_guard hold(mutex_);
  const auto found = find_job(id, key_name);
  if (found == jobs_.end() || found->second->state != JobReport::State::kDone) return nullptr;
  return found->second->response;
}

bool JobBoard::remove(const std::string& id, const std::string& key_name) {
  const std::lock_guard hold(mutex_);
  const auto found = find_job(id, key_name);
  if (found == jobs_.end()) return false;
  Job& job = *found->second;
  job.cancel.cancel();
  // The thread of a running job releases its bytes.
  if (job.state != JobReport::State::kRunning) charge(job, 0);
  jobs_.erase(found);
  return true;
}

std::shared_ptr<JobBoard::Job> JobBoard::next() {
  std::shared_ptr<Job> first;
  for (const auto& [id, job] : jobs_) {
    if (job->state == JobReport::State::kQueued && (!first || job->number < first->number))
      first = job;
  }
  return first;
}

void JobBoard::run() {
  lower_priority();
  std::unique_lock hold(mutex_);
  while (!ending_) {
    forget_old();
    const std::shared_ptr<Job> job = next();
    if (!job) {
      // Old answers are forgotten in time even if nobody asks.
      wake_.wait_for(hold, limits_.kept / 10 + std::chrono::seconds(1));
      continue;
    }
    job->state = JobReport::State::kRunning;
    hold.unlock();
    run_job(*job);
    hold.lock();
    std::string().swap(job->body);
    job->state = JobReport::State::kDone;
    job->ended = Clock::now();
    if (job->cancel.cancelled()) charge(*job, 0);
  }
}

void JobBoard::run_job(Job& job) {
  RequestMemory::Plan plan;
  const auto end = Clock::now() + std::chrono::minutes(10);
  for (;;) {
    RequestMemory memory(budget_, plan, RequestMemory::Wait::kWhileEmpty, &job.cancel);
    *job.response = {};
    Exchange exchange{.head = job.head,
                      .response = *job.response,
                      .body = nullptr,
                      .caller = &job.cancel,
                      .memory = &memory,
                      .request_id = job.request_id,
                      .may_repeat = !job.cancel.cancelled() && Clock::now() < end,
                      .whole_body = &job.body,
                      .progress = &job.progress};
    if (job.head.revoked && job.head.revoked->cancelled()) job.cancel.cancel();
    if (!job.cancel.cancelled()) answer_(exchange);
    if (exchange.is_put_off()) continue;
    if (job.response->status == 0)
      exchange.reply_problem(415, "MEDIA_TYPE_UNSUPPORTED", "a stream is no job");
    // The answer takes the place of the body.
    const std::lock_guard hold(mutex_);
    if (!charge(job, bytes_of(*job.response))) {
      exchange.reply_error(jobs_full("the answer of " + std::to_string(job.response->body.size()) +
                                     " bytes does not fit beside those of other jobs: ask for "
                                     "less, or DELETE jobs"));
      charge(job, bytes_of(*job.response));
    }
    return;
  }
}

}  // namespace sightline
