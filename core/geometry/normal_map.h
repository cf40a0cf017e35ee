#pragma once
/// How normals go where a matrix takes points.

#include "core/geometry/affine.h"

namespace sightline {

/// The inverse transpose of a matrix but for a positive factor, which normals do not have: its
/// cofactors, each within 1.5 units in the last place, with the exact sign of its determinant. A
/// matrix that flattens has the sign +.
class NormalMap {
 public:
  explicit NormalMap(const Affine& affine);
  /// Of length 1, by float64 sums: a rotation or an even scale costs some units in the last place,
  /// a matrix that flattens a thousandfold that many times more. NaN where there is no direction:
  /// `normal` is zero or not finite, or is flattened.
  Vec3d apply(const Vec3d& normal) const;

 private:
  double m_[3][3];
};

}  // namespace sightline
