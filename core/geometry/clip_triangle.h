#pragma once
/// A triangle clipped by planes, exactly.

#include <array>
#include <vector>

#include "core/geometry/dyadic_vector.h"

namespace sightline {

/// The rest of a triangle after clipping, in the triangle's own barycentric weights up to a
/// positive factor.
class ClippedTriangle {
 public:
  /// All of it.
  ClippedTriangle();

  /// Clips to the half space where a linear function is not positive; `values` are its values at
  /// the three corners. Returns whether anything is left; a single point counts. Throws
  /// std::bad_alloc.
  bool clip(const DyadicVector& values);

  /// The corners of what is left, some of them maybe twice: weights of degree 2d for values of
  /// degree d; their sum is positive.
  std::size_t size() const { return polygon_.size(); }
  const DyadicVector& weights(std::size_t i) const { return polygon_[i].at; }

 private:
  struct Corner {
    DyadicVector at;
    DyadicVector line;  ///< function that is zero here and at the next corner
  };
  std::vector<Corner> polygon_;
};

}  // namespace sightline

// Tests: tests/unit/geometry/triangle_box_test.cpp
