#include "core/geometry/clip_triangle.h"

#include <utility>

namespace sightline {

ClippedTriangle::ClippedTriangle() {
  const Dyadic one(1.0);
  polygon_.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    polygon_[i].at[i] = one;
    polygon_[i].line[(i + 2) % 3] = one;
  }
}

bool ClippedTriangle::clip(const DyadicVector& values) {
  std::vector<int> side;
  bool all_inside = true;
  for (const Corner& corner : polygon_) {
    side.push_back(dot(values, corner.at).sign());
    all_inside = all_inside && side.back() <= 0;
  }
  if (all_inside) return true;
  std::vector<Corner> left;
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    const Corner& corner = polygon_[i];
    const int after = side[(i + 1) % polygon_.size()];
    // Behind the last corner inside the border runs along the new plane.
    if (side[i] < 0 || (side[i] == 0 && after <= 0)) {
      left.push_back(corner);
    } else if (side[i] == 0) {
      left.push_back({corner.at, values});
    }
    if (side[i] * after >= 0) continue;
    DyadicVector crossing = cross(corner.line, values);
    if ((crossing[0] + crossing[1] + crossing[2]).sign() < 0) {
      for (Dyadic& weight : crossing) weight = -weight;
    }
    left.push_back({crossing, side[i] < 0 ? values : corner.line});
  }
  polygon_ = std::move(left);
  return !polygon_.empty();
}

}  // namespace sightline
