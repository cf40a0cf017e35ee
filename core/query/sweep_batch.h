#pragma once
/// SweepBatch: spheres and boxes that are swept along rays, as columns, and check_sweeps, which
/// validates all of them.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/box_sweep.h"
#include "core/geometry/sphere_sweep.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// n sweeps: the centre of a shape moves along a ray. Fill it with push_back(), then call
/// check_sweeps. Element i of every column belongs to sweep i.
struct SweepBatch {
  RayBatch rays;                ///< the paths of the centres
  Column<Vec3d> size;           ///< scene units: half extents of a box; x is the radius of a sphere
  Column<std::uint8_t> sphere;  ///< 1: sphere, 0: box

  std::size_t count() const { return size.size(); }
  /// Appends a sweep. Throws std::bad_alloc.
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
  /// The path of sweep i. Precondition: i < count().
  SweepPath path(std::size_t i) const {
    const Ray ray = rays[i];
    return {ray.origin, ray.direction, ray.tmin, ray.tmax};
  }
  /// Calls f with the SweptSphere or SweptBox of sweep i, and returns the result of f.
  template <class F>
  auto visit(std::size_t i, F&& f) const {
    return sphere[i] != 0 ? f(SweptSphere{size[i].x}) : f(SweptBox{size[i]});
  }
};

/// Maps the type of a swept shape to the type of its contact: ContactOf<SweptSphere>::Type is
/// SphereContact, ContactOf<SweptBox>::Type is BoxContact.
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

/// The first invalid sweep of a batch. The texts are constants, valid for ever.
struct SweepFault {
  /// The value of `component` if the whole part is invalid.
  static constexpr int kWhole = -1;

  std::size_t sweep = 0;
  const char* part = "";   ///< a part of RayFault, or "radius" or "half"
  int component = kWhole;  ///< index of the invalid number of "half"; kWhole for other parts
  const char* code = "";
  const char* message = "";
};

/// Validates sweeps of clients. Finds the first ray with a fault of check_rays. If there is none,
/// finds the first sweep with one of these faults:
///   SWEEP_SIZE_NOT_FINITE  a radius or half extent that is not finite
///   SWEEP_SIZE_NEGATIVE    a radius or half extent below 0
/// Returns true, and does not set `fault`, if every sweep is valid.
bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault);

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
