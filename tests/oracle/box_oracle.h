#pragma once
/// The judge of box queries: closed boxes in rational arithmetic. A box is the set of points p with
/// low_k <= normal_k . p <= high_k for three slabs; a missing bound is an unbounded side. Triangles
/// are clipped, not tested with separating axes, so that nothing here resembles the product's way.

#include <array>
#include <optional>

#include "core/geometry/box3.h"
#include "core/query/ray_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct Slab {
  std::array<mpq_class, 3> normal;
  std::optional<mpq_class> low, high;
};

struct ExactBox {
  std::array<Slab, 3> slabs;
};

/// A side of +-infinity is unbounded. Precondition: no NaN, min <= max.
ExactBox axis_aligned(const Box3d& box);

/// The points with |axes_k . (p - center)| <= half_k, for the float64 axes as they are, whether or
/// not they are exactly orthonormal. An infinite half is unbounded.
ExactBox oriented_by_slabs(const Vec3d& center, const std::array<Vec3d, 3>& axes,
                           const Vec3d& half);
/// The points center + sum a_k axes_k with |a_k| <= half_k. The same box as oriented_by_slabs only
/// if the axes are exactly orthonormal. Precondition: the axes are linearly independent.
ExactBox oriented_by_edges(const Vec3d& center, const std::array<Vec3d, 3>& axes,
                           const Vec3d& half);

/// Where the line origin + t direction is in one slab.
struct SlabTimes {
  bool parallel = false;  ///< then it is in the slab always or never
  bool never = false;
  std::optional<mpq_class> enter, leave;  ///< missing: unbounded on that side
  int enter_side = 0;                     ///< -1: the low plane, +1: the high plane, 0: none
};

/// The whole line against the box; limits of the ray play no part.
struct LineTimes {
  std::array<SlabTimes, 3> slabs;
  bool hit = false;
  std::optional<mpq_class> enter, leave;  ///< if hit; missing: unbounded
  bool origin_inside = false;             ///< strictly inside all three slabs
  bool origin_on_surface = false;         ///< in the closed box, on a plane of it
};
LineTimes line_times(const Ray& ray, const ExactBox& box);

/// Whether the closed box and the closed triangle share a point; touching counts.
/// Precondition: finite. A triangle without area counts as the segment or point that it is.
bool overlap(const ExactBox& box, const Triangle& triangle);

}  // namespace sightline::oracle
