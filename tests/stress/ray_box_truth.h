#pragma once
/// What a ray-box answer has to say, worked out from the oracle's rational numbers: where the
/// product compares quotients, this computes points and looks where they lie.

#include <array>
#include <optional>

#include "tests/oracle/box_oracle.h"

namespace sightline::stress {

struct RayBoxTruth {
  oracle::LineTimes line;
  bool behind = false;  ///< the line meets the box, but only before tmin
  bool beyond = false;  ///< only after tmax
  bool hit = false;
  std::optional<mpq_class> t;  ///< as RayBoxAnswer::t; nothing when no surface is met
  /// Faces (2 * axis + upper) that hold the point at t.
  std::array<bool, 6> faces{};
  /// The six planes, -x +x -y +y -z +z; nothing for one that is parallel or missing.
  std::array<std::optional<mpq_class>, 6> planes;

  /// Whether slabs a and b (a == b: that one alone) have no t in common.
  bool exclude(std::size_t a, std::size_t b) const;
};

RayBoxTruth ray_box_truth(const Ray& ray, const oracle::ExactBox& box);

}  // namespace sightline::stress
