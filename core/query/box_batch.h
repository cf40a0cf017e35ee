#pragma once
/// Boxes of a query as columns, and the check at the border that all of them pass.

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/column.h"
#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_convex.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// n closed boxes, axis-aligned and oriented ones mixed, and other shapes where a query takes them.
struct BoxBatch {
  static constexpr std::uint32_t kAligned = 0xffffffffu;
  /// The two upper bits of a slot say which column its number counts in.
  static constexpr std::uint32_t kShapeBits = 0xc0000000u, kBoxShape = 0,
                                 kSphereShape = 0x40000000u, kCapsuleShape = 0x80000000u,
                                 kConvexShape = 0xc0000000u;

  Column<Box3d> aligned;  ///< n slots; unused for the others
  /// n slots: kAligned, or a shape and a number in its column.
  Column<std::uint32_t> oriented;
  Column<OrientedBox> oriented_boxes;
  Column<Sphere> spheres;
  Column<Capsule> capsules;
  /// Region i has the planes first_plane[i] .. first_plane[i + 1].
  Column<HalfSpace> planes;
  Column<std::size_t> first_plane{0};

  std::size_t size() const { return oriented.size(); }
  void push_back(const Box3d& box);
  void push_back(const OrientedBox& box);
  void push_back(const Sphere& sphere);
  void push_back(const Capsule& capsule);
  /// Copies the planes.
  void push_back(const ConvexRegion& region);
  bool is_aligned(std::size_t i) const { return oriented[i] == kAligned; }

  /// Calls f with the shape of slot i, and returns what it returns.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    const std::uint32_t shape = is_aligned(i) ? kBoxShape : oriented[i] & kShapeBits;
    const std::uint32_t number = oriented[i] & ~kShapeBits;
    if (shape == kSphereShape) return f(spheres[number]);
    if (shape == kCapsuleShape) return f(capsules[number]);
    if (shape == kConvexShape) return f(region(number));
    return visit_box(i, f);
  }
  ConvexRegion region(std::size_t number) const {
    return {{planes.data() + first_plane[number], planes.data() + first_plane[number + 1]}};
  }
  /// As the visitor above, for a batch that has only boxes.
  template <class F>
  auto visit_box(std::size_t i, F&& f) const {
    return is_aligned(i) ? f(aligned[i]) : f(oriented_boxes[oriented[i]]);
  }
};

/// The place of a bad box in a batch.
struct BoxFault {
  static constexpr int kWhole = -1;

  std::size_t box = 0;
  /// "min", "max", "center", "half", "axes", "radius", "from", "to" or "planes"
  const char* part = "";
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
///   BOX_PLANES_COUNT     no plane, or more than ConvexRegion::kMostPlanes
///   BOX_PLANE_ZERO       a plane's normal of exactly zero
/// Returns true and leaves `fault` alone when every box is good.
bool check_boxes(const BoxBatch& boxes, BoxFault& fault);

/// A rotation that is meant as one: its squared length is within 1% of 1. The axes are made by the
/// formula of rotated_axes, which normalises nothing.
bool is_rotation(double x, double y, double z, double w);

}  // namespace sightline
