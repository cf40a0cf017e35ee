#pragma once
/// BoxBatch: the boxes and other shapes of a query as columns, and check_boxes, which validates all
/// of them.

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/column.h"
#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/convex/point_hull.h"
#include "core/geometry/triangle_capsule.h"
#include "core/geometry/triangle_convex.h"
#include "core/geometry/triangle_sphere.h"

namespace sightline {

/// n closed shapes: axis-aligned boxes, oriented boxes and, in queries that allow them, spheres,
/// capsules, convex regions and hulls of points. Slot i holds shape i. Fill it with push_back(), call check_boxes,
/// read it with visit().
struct BoxBatch {
  /// The value of `oriented` for an axis-aligned box.
  static constexpr std::uint32_t kAligned = 0xffffffffu;
  /// The three upper bits of another value of `oriented` are the type of the shape; the other bits
  /// are the index in the column of that type.
  static constexpr std::uint32_t kShapeBits = 0xe0000000u, kBoxShape = 0,
                                 kSphereShape = 0x20000000u, kCapsuleShape = 0x40000000u,
                                 kConvexShape = 0x60000000u, kHullShape = 0x80000000u;

  Column<Box3d> aligned;  ///< n slots; empty boxes except for axis-aligned boxes
  /// n slots: kAligned, or a type of shape and an index in its column.
  Column<std::uint32_t> oriented;
  Column<OrientedBox> oriented_boxes;  ///< for kBoxShape
  Column<Sphere> spheres;              ///< for kSphereShape
  Column<Capsule> capsules;            ///< for kCapsuleShape
  /// For kConvexShape: the planes of region i are planes[first_plane[i]] .. planes[first_plane[i +
  /// 1] - 1].
  Column<HalfSpace> planes;
  Column<std::size_t> first_plane{0};
  /// For kHullShape, in the same way.
  Column<Vec3d> points;
  Column<std::size_t> first_point{0};

  std::size_t size() const { return oriented.size(); }
  /// Each push_back appends a shape. Throws std::bad_alloc.
  void push_back(const Box3d& box);
  void push_back(const OrientedBox& box);
  void push_back(const Sphere& sphere);
  void push_back(const Capsule& capsule);
  /// Copies the planes of the region.
  void push_back(const ConvexRegion& region);
  /// Copies the points of the hull.
  void push_back(const PointHull& hull);
  bool is_aligned(std::size_t i) const { return oriented[i] == kAligned; }
  bool is_convex_region(std::size_t i) const {
    return !is_aligned(i) && (oriented[i] & kShapeBits) == kConvexShape;
  }

  /// Calls f with the shape of slot i, and returns the result of f. f accepts every type of shape,
  /// with one type of result.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    const std::uint32_t shape = is_aligned(i) ? kBoxShape : oriented[i] & kShapeBits;
    const std::uint32_t number = oriented[i] & ~kShapeBits;
    if (shape == kSphereShape) return f(spheres[number]);
    if (shape == kCapsuleShape) return f(capsules[number]);
    if (shape == kConvexShape) return f(region(number));
    if (shape == kHullShape) return f(hull(number));
    return visit_box(i, f);
  }
  /// The convex region at an index of the column. It refers to `planes`, so a push_back makes it
  /// invalid.
  ConvexRegion region(std::size_t number) const {
    return {{planes.data() + first_plane[number], planes.data() + first_plane[number + 1]}};
  }
  /// The hull at an index of the column. It refers to `points`.
  PointHull hull(std::size_t number) const {
    return {{points.data() + first_point[number], points.data() + first_point[number + 1]}};
  }
  /// visit() for a batch that has only axis-aligned and oriented boxes.
  template <class F>
  auto visit_box(std::size_t i, F&& f) const {
    return is_aligned(i) ? f(aligned[i]) : f(oriented_boxes[oriented[i]]);
  }
};

/// The first invalid shape of a batch. The texts are constants, valid for ever.
struct BoxFault {
  /// The value of `component` if the whole part is invalid.
  static constexpr int kWhole = -1;

  std::size_t box = 0;  ///< its slot
  /// "min", "max", "center", "half", "axes", "radius", "from", "to", "planes" or "hull"
  const char* part = "";
  /// Index of the invalid number in the part; of "axes" the axis, of "planes" the plane,
  /// of "hull" the point.
  int component = kWhole;
  const char* code = "";  ///< one of the codes at check_boxes
  const char* message = "";
};

/// Validates shapes of clients. An open side of a box is an infinite min, max or half. Finds the
/// first shape with one of these faults:
///   BOX_NOT_FINITE       a NaN, a min of +inf, a max of -inf, or an infinite number in a
///                        part other than min, max and half
///   BOX_REVERSED         min > max on an axis
///   BOX_HALF_NEGATIVE    half < 0
///   BOX_RADIUS_NEGATIVE  radius < 0
///   BOX_AXIS_ZERO        an axis of exactly zero
///   BOX_AXES_DEPENDENT   three axes in one plane, exactly
///   BOX_PLANES_COUNT     no plane, or more than ConvexRegion::kMostPlanes
///   BOX_PLANE_ZERO       a plane's normal of exactly zero
///   BOX_HULL_COUNT       no point, or more than PointHull::kMostPoints
/// Returns true, and does not set `fault`, if every box is valid.
bool check_boxes(const BoxBatch& boxes, BoxFault& fault);

/// True if the squared length of a quaternion is within 1% of 1, so that it represents a rotation.
/// rotated_axes uses the quaternion as it is, without normalising it.
bool is_rotation(double x, double y, double z, double w);

}  // namespace sightline
