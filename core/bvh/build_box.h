#pragma once
/// The input of tree builders: BuildBox, and bounds of ranges of boxes. All coordinates are
/// float32, in tree units (wide_tree.h).

#include <array>
#include <cstdint>
#include <limits>

#include "core/bvh/float4.h"

namespace sightline {

/// A box, lower to upper, around `count` triangles or entries, whose numbers follow each other from
/// `id` on. 32 bytes, so that a partition moves whole vectors.
struct alignas(32) BuildBox {
  float lower[3];
  std::uint32_t id;
  float upper[3];
  std::uint32_t count;

  /// Twice the centroid: lower + upper; lane 3 is 0.
  Float4 middle() const {
    // The id must not enter the sum: as a float32 it is subnormal, and adding those is slow.
    return (Float4::load(lower) + Float4::load(upper)).without_last();
  }
  /// Swaps by whole vectors: loading a vector soon after its numbers were stored one by one stalls.
  friend void swap(BuildBox& a, BuildBox& b) {
    const Float4 low = Float4::load(a.lower), high = Float4::load(a.upper);
    Float4::load(b.lower).store(a.lower);
    Float4::load(b.upper).store(a.upper);
    low.store(b.lower);
    high.store(b.upper);
  }
};

/// Bounds of points and boxes; empty by default. Lane 3 holds an unrelated value (an id,
/// reinterpreted) that is never used; the lanes 0 to 2 are x, y, z.
struct Bounds {
  Float4 lower = Float4::all(std::numeric_limits<float>::infinity());
  Float4 upper = Float4::all(-std::numeric_limits<float>::infinity());

  /// Each include() extends the bounds to contain its argument.
  void include(Float4 low, Float4 high) {
    lower = min(lower, low);
    upper = max(upper, high);
  }
  void include(Float4 point) { include(point, point); }
  /// Extends the bounds in the lanes in which `point` is not NaN.
  void include_numbers(Float4 point) { include_numbers({point, point}); }
  void include_numbers(const Bounds& other) {
    lower = min(other.lower, lower);
    upper = max(other.upper, upper);
  }
  void include(const Bounds& other) { include(other.lower, other.upper); }
  void include(const BuildBox& box) { include(Float4::load(box.lower), Float4::load(box.upper)); }
  /// Half the surface area: of an empty box infinite.
  float half_area() const { return (upper - lower).without_last().product_sum(); }
};

/// Three bounds, one for each axis of a cut.
struct BoundsPerAxis {
  std::array<Bounds, 3> axis;

  /// Bounds::half_area, in lanes 0 to 2; lane 3 has no meaning.
  Float4 half_areas() const {
    return Float4::product_sums(axis[0].upper - axis[0].lower, axis[1].upper - axis[1].lower,
                                axis[2].upper - axis[2].lower);
  }
};

/// The bounds of a range of boxes, and the bounds of their doubled centroids (BuildBox::middle).
struct RangeBounds {
  Bounds boxes;
  Bounds middles;

  /// Each include() extends both to contain its argument.
  void include(const BuildBox& box) {
    boxes.include(box);
    middles.include(box.middle());
  }
  void include(const RangeBounds& other) {
    boxes.include(other.boxes);
    middles.include(other.middles);
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
