#include "core/query/range_noise.h"

#include <algorithm>

namespace sightline {

RangeErrors::RangeErrors(const RangeNoise& noise, std::uint64_t ray)
    : numbers_(stream_of(noise.seed, ray)),
      sigma_(noise.sigma),
      is_dropped_(numbers_.unit() < noise.dropout) {}

double RangeErrors::measured(double t, double tmin) {
  double sum = 0;
  for (int i = 0; i < 12; ++i) sum += numbers_.unit();
  return std::max(t + sigma_ * (sum - 6), tmin);
}

}  // namespace sightline
