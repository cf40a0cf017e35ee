#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <vector>

#include "core/run/engine_state.h"

namespace sightline {
namespace {

TEST(Turns, are_not_waited_for_without_end) {
  Turns turns;
  turns.start(2);
  const Deadline never = Deadline::never();
  std::optional<Turns::Turn> first(std::in_place, turns, never),
      second(std::in_place, turns, never);
  EXPECT_TRUE(turns.all_wanted());
  // Both may last for minutes: who comes next goes on beside them.
  const Turns::Turn third(turns, never);
  first.reset();
  EXPECT_TRUE(turns.all_wanted());
  second.reset();
  EXPECT_FALSE(turns.all_wanted());  // one of two
}

TEST(Turns, are_not_waited_for_beyond_a_deadline) {
  Turns turns;
  // Nobody is so patient: this ends because of the deadline, or never.
  turns.start(1, std::chrono::hours(24));
  const Turns::Turn first(turns, Deadline::never());
  const Deadline soon = Deadline::in(std::chrono::milliseconds(1));
  const Turns::Turn second(turns, soon);
  // What runs next sees that it has passed, and says so.
  EXPECT_TRUE(soon.passed());
}

TEST(Share, takes_each_piece_once_on_no_more_threads_than_it_may) {
  ThreadGroup threads;
  threads.start(4);
  for (const int most : {0, 1, 2, 3, 4, 100}) {
    std::vector<std::atomic<int>> taken(203);
    std::atomic<int> active{0}, peak{0};
    share(threads, 3, taken.size(), most, [&](std::size_t i) {
      const int now = ++active;
      for (int seen = peak; seen < now && !peak.compare_exchange_weak(seen, now);) {
      }
      ++taken[i];
      --active;
    });
    for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_EQ(taken[i], i < 3 ? 0 : 1);
    EXPECT_LE(peak, most == 0 ? 203 : most);
  }
}

}  // namespace
}  // namespace sightline
