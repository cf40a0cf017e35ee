#include "server/short_turns.h"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <thread>

namespace sightline {

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

void ask_to_go_first() {
#if defined(SCHED_RESET_ON_FORK)
  if (std::thread::hardware_concurrency() < 2) return;
  sched_param lowest{};
  lowest.sched_priority = ::sched_get_priority_min(SCHED_RR);
  (void)::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &lowest);
#endif
}

}  // namespace sightline
