#pragma once
/// Boxes of a query as columns, and the one border check that they pass.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// n closed boxes, axis-aligned and oriented ones mixed, and spheres where a query takes them.
struct BoxBatch {
  static constexpr std::uint32_t kAligned = 0xffffffffu, kSphereBit = 0x80000000u;

  Column<Box3d> aligned;  ///< n slots; unused for the others
  /// n slots: kAligned, the box's number in oriented_boxes, or kSphereBit and one in spheres.
  Column<std::uint32_t> oriented;
  Column<OrientedBox> oriented_boxes;
  Column<Sphere> spheres;

  std::size_t size() const { return oriented.size(); }
  void push_back(const Box3d& box);
  void push_back(const OrientedBox& box);
  void push_back(const Sphere& sphere);
  bool is_aligned(std::size_t i) const { return oriented[i] == kAligned; }

  /// Calls f with the Box3d, the OrientedBox or the Sphere of slot i, and returns what it returns.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    if (!is_aligned(i) && (oriented[i] & kSphereBit) != 0) {
      return f(spheres[oriented[i] & ~kSphereBit]);
    }
    return visit_box(i, f);
  }
  /// The same where there are no spheres.
  template <class F>
  auto visit_box(std::size_t i, F&& f) const {
    return is_aligned(i) ? f(aligned[i]) : f(oriented_boxes[oriented[i]]);
  }
};

/// The place of a bad box in a batch.
struct BoxFault {
  static constexpr int kWhole = -1;

  std::size_t box = 0;
  const char* part = "";   ///< "min", "max", "center", "half", "axes" or "radius"
  int component = kWhole;  ///< of the part
  const char* code = "";
  const char* message = "";
};

/// The border. Open sides are an infinite min, max or half. Finds the first box with
///   BOX_NOT_FINITE       a NaN, a min of +inf, a max of -inf, an infinite center, axis or radius
///   BOX_REVERSED         min > max on an axis
///   BOX_HALF_NEGATIVE    half < 0
///   BOX_RADIUS_NEGATIVE  radius < 0
///   BOX_AXIS_ZERO        an axis of exactly zero
///   BOX_AXES_DEPENDENT   three axes in one plane, exactly
/// Returns true and leaves `fault` alone when every box is good.
bool check_boxes(const BoxBatch& boxes, BoxFault& fault);

/// A rotation that is meant as one: its squared length is within 1% of 1. The axes are made by the
/// formula of rotated_axes, which normalises nothing.
bool is_rotation(double x, double y, double z, double w);

}  // namespace sightline
