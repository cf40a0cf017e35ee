#include <gtest/gtest.h>

#include <optional>

#include "core/run/engine_state.h"

namespace sightline {
namespace {

TEST(Turns, are_not_waited_for_without_end) {
  Turns turns;
  turns.start(2);
  std::optional<Turns::Turn> first(std::in_place, turns), second(std::in_place, turns);
  EXPECT_TRUE(turns.all_wanted());
  // Both may last for minutes: who comes next goes on beside them.
  const Turns::Turn third(turns);
  first.reset();
  EXPECT_TRUE(turns.all_wanted());
  second.reset();
  EXPECT_FALSE(turns.all_wanted());  // one of two
}

}  // namespace
}  // namespace sightline
