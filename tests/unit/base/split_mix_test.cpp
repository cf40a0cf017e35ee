#include "core/base/split_mix.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(SplitMix, gives_the_published_sequence) {
  // The first numbers of Vigna's splitmix64.c for the seed 1234567.
  SplitMix numbers(1234567);
  for (const std::uint64_t published :
       {6457827717110365317u, 3203168211198807973u, 9817491932198370423u, 4593380528125082431u}) {
    EXPECT_EQ(numbers.bits(), published);
  }
}

TEST(SplitMix, draws_from_zero_inclusive_to_one_exclusive) {
  SplitMix numbers(7);
  for (int i = 0; i < 10000; ++i) {
    const double unit = numbers.unit();
    EXPECT_GE(unit, 0);
    EXPECT_LT(unit, 1);
  }
}

}  // namespace
}  // namespace sightline
