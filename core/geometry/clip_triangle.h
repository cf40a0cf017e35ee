#pragma once
/// ClippedTriangle: a triangle clipped by one plane after another, exactly.

#include <array>
#include <vector>

#include "core/geometry/dyadic_vector.h"

namespace sightline {

/// The polygon that remains of a triangle after clipping. Start with the whole triangle, and call
/// clip() for each plane. A corner of the polygon is stored as three barycentric weights of the
/// triangle's corners, up to a positive factor. No coordinates are stored: clip() gets values of a
/// linear function.
class ClippedTriangle {
 public:
  /// The whole triangle.
  ClippedTriangle();

  /// Clips to the half-space where a linear function is at most zero; `values` are its values at
  /// the three corners of the triangle. Returns true if at least one point is left. Precondition:
  /// no earlier call returned false. Throws std::bad_alloc.
  bool clip(const DyadicVector& values);

  /// The number of corners of the remaining polygon; a corner may be listed twice.
  std::size_t size() const { return polygon_.size(); }
  /// The weights of corner i, in the order around the polygon; their sum is positive. If the values
  /// given to clip() are polynomials of degree d, the weights have degree 2d. Precondition: i <
  /// size().
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
