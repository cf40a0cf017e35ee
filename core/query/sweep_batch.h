#pragma once
/// SweepBatch: spheres, capsules and boxes that are swept along rays, as columns, and check_sweeps,
/// which validates all of them.

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/box_sweep.h"
#include "core/geometry/capsule_sweep.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// The shape of a sweep.
enum class SweepShape : std::uint8_t { kBox, kSphere, kCapsule, kOrientedBox };

/// n sweeps: a point of a shape moves along a ray, the first end of a capsule and the centre of the
/// others. Fill it with push_back(), then call check_sweeps. Element i of `rays`, `size`, `shape`
/// and `number` belongs to sweep i.
struct SweepBatch {
  RayBatch rays;       ///< the paths
  Column<Vec3d> size;  ///< scene units: half extents of a box; x is the radius of other shapes
  Column<SweepShape> shape;
  Column<std::uint32_t> number;       ///< of a capsule or an oriented box, in its column
  Column<Vec3d> ends;                 ///< of capsules: the second end, at t = 0
  Column<std::array<Vec3d, 3>> axes;  ///< of oriented boxes

  std::size_t count() const { return size.size(); }
  /// Each appends a sweep. Throws std::bad_alloc.
  void push_back_sphere(const Ray& ray, double radius) {
    append(ray, {radius, 0, 0}, SweepShape::kSphere, 0);
  }
  void push_back(const Ray& ray, const SweptCapsule& capsule) {
    append(ray, {capsule.radius, 0, 0}, SweepShape::kCapsule, ends.size());
    ends.push_back(capsule.to);
  }
  void push_back(const Ray& ray, const SweptBox& box) {
    append(ray, box.half, box.axes ? SweepShape::kOrientedBox : SweepShape::kBox, axes.size());
    if (box.axes) axes.push_back(*box.axes);
  }
  /// The path of sweep i. Precondition: i < count().
  SweepPath path(std::size_t i) const {
    const Ray ray = rays[i];
    return {ray.origin, ray.direction, ray.tmin, ray.tmax};
  }
  /// Calls f with the SweptCapsule or SweptBox of sweep i, and returns the result of f.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    switch (shape[i]) {
      case SweepShape::kSphere:
        return f(SweptCapsule{rays[i].origin, size[i].x});
      case SweepShape::kCapsule:
        return f(SweptCapsule{ends[number[i]], size[i].x});
      case SweepShape::kOrientedBox:
        return f(SweptBox{size[i], axes[number[i]]});
      case SweepShape::kBox:
        break;
    }
    return f(SweptBox{size[i]});
  }

 private:
  void append(const Ray& ray, const Vec3d& extent, SweepShape kind, std::size_t place) {
    rays.push_back(ray);
    size.push_back(extent);
    shape.push_back(kind);
    number.push_back(static_cast<std::uint32_t>(place));
  }
};

/// Maps the type of a swept shape to the type of its contact: ContactOf<SweptCapsule>::Type is
/// CapsuleContact, ContactOf<SweptBox>::Type is BoxContact.
template <class Shape>
struct ContactOf;
template <>
struct ContactOf<SweptCapsule> {
  using Type = CapsuleContact;
};
template <>
struct ContactOf<SweptBox> {
  using Type = BoxContact;
};

/// The first invalid sweep of a batch. The texts are constants, valid for ever.
struct SweepFault {
  /// The value of `component` if the whole part is invalid.
  static constexpr int kWhole = -1;

  std::size_t sweep = 0;
  const char* part = "";   ///< a part of RayFault, or "radius", "half", "to" or "axes"
  int component = kWhole;  ///< index of the invalid number, or axis; kWhole for other parts
  const char* code = "";
  const char* message = "";
};

/// Validates sweeps of clients. Finds the first ray with a fault of check_rays. If there is none,
/// finds the first sweep with one of these faults:
///   SWEEP_SIZE_NOT_FINITE  a radius or half extent that is not finite
///   SWEEP_SIZE_NEGATIVE    a radius or half extent below 0
///   BOX_NOT_FINITE, BOX_AXIS_ZERO, BOX_AXES_DEPENDENT  of the end of a capsule, of the axes of a
///                          box: those of check_boxes (box_batch.h)
/// Returns true, and does not set `fault`, if every sweep is valid.
bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
