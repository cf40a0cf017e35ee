#pragma once
/// SweepBatch: spheres and boxes that are swept along rays, as columns, and check_sweeps, the
/// validation of all of them.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/box_sweep.h"
#include "core/geometry/sphere_sweep.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// n sweeps: the centre of a shape moves along a ray.
struct SweepBatch {
  RayBatch rays;
  Column<Vec3d> size;           ///< half extents of a box; for a sphere x is the radius
  Column<std::uint8_t> sphere;  ///< 1: sphere, 0: box

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
  /// Calls f with the SweptSphere or SweptBox of slot i, and returns the result of f.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    return sphere[i] != 0 ? f(SweptSphere{size[i].x}) : f(SweptBox{size[i]});
  }
};

/// The type of the contact of a swept shape: ContactOf<SweptSphere>::Type,
/// ContactOf<SweptBox>::Type.
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

/// The first invalid sweep of a batch.
struct SweepFault {
  static constexpr int kWhole = -1;

  std::size_t sweep = 0;
  const char* part = "";   ///< a part of RayFault, or "radius" or "half"
  int component = kWhole;  ///< index of the invalid number of "half"
  const char* code = "";
  const char* message = "";
};

/// Validates sweeps of clients. Finds the first sweep with a fault of check_rays or one of these:
///   SWEEP_SIZE_NOT_FINITE  a radius or half extent that is not finite
///   SWEEP_SIZE_NEGATIVE    a radius or half extent below 0
/// Returns true, and does not set `fault`, if every sweep is valid.
bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
