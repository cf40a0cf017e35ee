#pragma once
/// Medians and the spread around them.

#include <vector>

namespace sightline::bench {

struct Spread {
  double median = 0;
  double least = 0;
  double most = 0;
};

/// All zero without values. The median of an even number is the mean of the middle two.
Spread spread_of(std::vector<double> values);

/// How many times faster `ours` is: the ratio of the medians of time, and the least and most over
/// repetitions made side by side. Precondition: as many of the one as of the other.
Spread speed_ratio(const std::vector<double>& theirs, const std::vector<double>& ours);

/// 0 without values. Precondition: all are positive.
double geometric_mean(const std::vector<double>& values);

}  // namespace sightline::bench
