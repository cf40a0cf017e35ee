#pragma once
/// Spheres and boxes swept along rays, as columns, and the check at the border that all of them
/// pass.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/box_sweep.h"
#include "core/geometry/sphere_sweep.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// n sweeps: the centre of the shape goes along a ray.
struct SweepBatch {
  RayBatch rays;
  Column<Vec3d> size;           ///< half extents of a box; x alone: the radius of a sphere
  Column<std::uint8_t> sphere;  ///< 1 or 0

  std::size_t count() const { return size.size(); }
  void push_back(const Ray& ray, const SweptSphere& shape) {
    rays.push_back(ray);
    size.push_back({shape.radius, 0, 0});
    sphere.push_back(1);
  }
  void push_back(const Ray& ray, const SweptBox& box) {
    rays.push_back(ray);
    size.push_back(box.half);
    sphere.push_back(0);
  }
  SweepPath path(std::size_t i) const {
    const Ray ray = rays[i];
    return {ray.origin, ray.direction, ray.tmin, ray.tmax};
  }
  /// Calls f with the SweptSphere or the SweptBox of slot i, and returns what it returns.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    return sphere[i] != 0 ? f(SweptSphere{size[i].x}) : f(SweptBox{size[i]});
  }
};

/// The contact of a shape that is swept.
template <class Shape>
struct ContactOf;
template <>
struct ContactOf<SweptSphere> {
  using Type = SphereContact;
};
template <>
struct ContactOf<SweptBox> {
  using Type = BoxContact;
};

/// The place of a bad sweep in a batch.
struct SweepFault {
  static constexpr int kWhole = -1;

  std::size_t sweep = 0;
  const char* part = "";   ///< that of a ray, or "radius" or "half"
  int component = kWhole;  ///< of "half"
  const char* code = "";
  const char* message = "";
};

/// The border: rays as check_rays has them, and
///   SWEEP_SIZE_NOT_FINITE  a radius or half extent that is no finite number
///   SWEEP_SIZE_NEGATIVE    one below 0
/// Returns true and leaves `fault` alone when every sweep is good.
bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
