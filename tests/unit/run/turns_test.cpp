#include <gtest/gtest.h>

#include <optional>

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

}  // namespace
}  // namespace sightline
