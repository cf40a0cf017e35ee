#include "server/http/short_turns.h"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <ctime>
#include <thread>

namespace sightline {
namespace {

/// False where the system knows or allows no such thing.
bool go_first(bool first) {
#if defined(SCHED_RESET_ON_FORK)
  const int policy = first ? SCHED_RR : SCHED_OTHER;
  sched_param lowest{};
  lowest.sched_priority = ::sched_get_priority_min(policy);
  if (::sched_setscheduler(0, policy | SCHED_RESET_ON_FORK, &lowest) != 0) return false;
  if (!first) ask_for_short_turns();
  return true;
#else
  return false;
#endif
}

std::chrono::nanoseconds time_computed() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

void ask_for_short_turns() {
#if defined(SYS_sched_setattr) && defined(SYS_sched_getattr)
  // sched_setattr(2); glibc knows neither the calls nor this.
  struct {
    std::uint32_t size, policy;
    std::uint64_t flags;
    std::int32_t nice;
    std::uint32_t priority;
    std::uint64_t runtime, deadline, period;
  } attributes{};
  if (::syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
  constexpr std::uint64_t kShortest = 100'000;  // nanoseconds
  if (attributes.policy != SCHED_OTHER) return;
  attributes.runtime = kShortest;
  (void)::syscall(SYS_sched_setattr, 0, &attributes, 0);
#endif
}

GoingFirst::GoingFirst()
    : allowed_(std::thread::hardware_concurrency() > 1 && go_first(true)),
      first_(allowed_),
      computed_(time_computed()),
      looked_(Clock::now()) {}

void GoingFirst::look(Clock::time_point now) {
  if (!allowed_) return;
  const std::chrono::nanoseconds computed = time_computed();
  if ((computed - computed_) * 3 > now - looked_) back_until_ = now + std::chrono::seconds(1);
  computed_ = computed;
  looked_ = now;
  const bool wanted = now >= back_until_;
  if (wanted != first_ && go_first(wanted)) first_ = wanted;
}

}  // namespace sightline
