#pragma once
/// A triangle clipped by planes, exactly.

#include <array>
#include <vector>

#include "core/geometry/dyadic_vector.h"

namespace sightline {

/// The polygon that remains of a triangle after clipping. Its corners are barycentric weights of
/// the triangle's corners, up to a positive factor. It refers to no coordinates: clip() gets values
/// of a linear function.
class ClippedTriangle {
 public:
  /// The whole triangle.
  ClippedTriangle();

  /// Clips to the half-space where a linear function is at most zero; `values` are its values at
  /// the three corners of the triangle. Returns true if at least one point is left. Throws
  /// std::bad_alloc.
  bool clip(const DyadicVector& values);

  /// The corners of the remaining polygon, in order; a corner may be listed twice. The sum of its
  /// weights is positive. If the values given to clip() are polynomials of degree d, the weights
  /// have degree 2d.
  std::size_t size() const { return polygon_.size(); }
  const DyadicVector& weights(std::size_t i) const { return polygon_[i].at; }

 private:
  struct Corner {
    DyadicVector at;
    DyadicVector line;  ///< linear function that is zero at this corner and the next one
  };
  std::vector<Corner> polygon_;
};

}  // namespace sightline

// Tests: tests/unit/geometry/triangle_box_test.cpp
