#include "tests/bench/statistics.h"

#include <gtest/gtest.h>

namespace sightline::bench {
namespace {

TEST(Statistics, takes_the_middle_of_an_odd_number_and_the_mean_of_the_middle_two_of_an_even_one) {
  EXPECT_EQ(spread_of({9, 1, 5}).median, 5);
  EXPECT_EQ(spread_of({9, 1, 5, 7}).median, 6);
}

TEST(Statistics, spreads_from_the_least_to_the_most) {
  const Spread spread = spread_of({4, 2, 8});
  EXPECT_EQ(spread.least, 2);
  EXPECT_EQ(spread.most, 8);
  EXPECT_EQ(spread_of({}).median, 0);
}

TEST(Statistics, compares_medians_and_spreads_over_repetitions_made_side_by_side) {
  // The slow repetition was slow for both: their ratio does not spread.
  const Spread ratio = speed_ratio({200, 220, 400}, {100, 110, 200});
  EXPECT_EQ(ratio.median, 2);
  EXPECT_EQ(ratio.least, 2);
  EXPECT_EQ(ratio.most, 2);
}

TEST(Statistics, averages_ratios_geometrically) {
  EXPECT_DOUBLE_EQ(geometric_mean({0.5, 2}), 1);
  EXPECT_EQ(geometric_mean({}), 0);
}

}  // namespace
}  // namespace sightline::bench
