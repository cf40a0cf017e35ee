#pragma once
/// Answers a batch of rays: from the query to the encoded text.

#include <chrono>
#include <cstdint>
#include <string>

#include "core/base/watch.h"
#include "proto/json/answer_members.h"
#include "proto/json/ray_json.h"
#include "server/service/service.h"

namespace sightline {

/// The questions about rays.
enum class RayQuestionKind { kClosest, kAny, kAll, kCount };

/// The rules for the body of a question: which keys it may have, and the present limits.
RayJsonRules rules_of(RayQuestionKind kind, const ServiceLimits& limits);

/// Measures the times of the steps of a request, in microseconds. Not thread-safe.
class WorkTimer {
 public:
  /// Adds the time since the last call, or since construction, to a member of `report`.
  void add(std::uint64_t WorkReport::*step) {
    const Clock::time_point now = Clock::now();
    report.*step += static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(now - last_).count());
    last_ = now;
  }
  /// Lets the next add() begin now.
  void restart() { last_ = Clock::now(); }

  WorkReport report;  ///< the times so far, and the work that others count

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

/// Traces the rays of a query, describes their hits, and encodes them in the query's layout.
/// Returns the body of the answer. Reserves the memory of each step by options.reserve, which may
/// be null. Errors: those of the engine and of the reservation.
Result<std::string> answer_rays(RayQuestionKind kind, const Service& service, const Scene& scene,
                                const RayQuery& query, const RayOptions& options,
                                const Deadline& deadline, WorkTimer& timer);

}  // namespace sightline

// Tests: tests/integration/rays_test.py
