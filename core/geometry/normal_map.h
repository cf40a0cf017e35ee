#pragma once
/// NormalMap: maps normals of a surface when an affine map transforms the surface.

#include "core/geometry/affine.h"

namespace sightline {

/// The inverse transpose of the map's 3x3 matrix, up to a positive factor, which does not matter
/// for normals. Construct it once for each affine map, and call apply() for each normal. It is
/// stored as the cofactors times the sign of the determinant. Each cofactor is within 1.5 units in
/// the last place of the matrix scaled to size 1; the sign is exact. For a singular matrix the sign
/// is +.
class NormalMap {
 public:
  /// Precondition: the elements of `affine` are finite.
  explicit NormalMap(const Affine& affine);
  /// The normal of length 1 on the mapped surface, for a normal of any length. Its error is some
  /// units in the last place for a rotation or a uniform scale, and a thousand times that for a
  /// matrix that flattens a thousandfold. All components are NaN if there is no such direction:
  /// `normal` is zero or not finite, or its image is zero.
  Vec3d apply(const Vec3d& normal) const;
  /// True if the map is a reflection, exactly.
  bool is_mirror() const { return is_mirror_; }

 private:
  double m_[3][3];
  bool is_mirror_ = false;
};

/// The direction with length 1. NaN if it is zero or not finite.
Vec3d unit_or_nan(const Vec3d& direction);

}  // namespace sightline
