#include "core/geometry/float64_vector.h"

namespace sightline::float64 {

std::array<double, 2> near_weights(const std::array<Numbers, 3>& corner, const Numbers& ab,
                                   const Numbers& ac) {
  const auto &a = corner[0], &b = corner[1], &c = corner[2];
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  double v = 0, w = 0;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    v = d1 / (d1 - d3);
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    w = d2 / (d2 - d6);
  } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
    w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    v = 1 - w;
  } else {
    const double sum = va + vb + vc;
    v = vb / sum;
    w = vc / sum;
  }
  // NaN becomes 0 here.
  v = v > 0 ? std::min(v, 1.0) : 0;
  w = w > 0 ? std::min(w, 1 - v) : 0;
  return {v, w};
}

}  // namespace sightline::float64
