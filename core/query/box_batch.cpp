#include "core/query/box_batch.h"

#include <cmath>

#include "core/base/infinity.h"

namespace sightline {

namespace {

/// What is wrong with one box, without its number. An empty code: nothing.
BoxFault fault_of(const Box3d& box) {
  for (int k = 0; k < 3; ++k) {
    if (!(box.min[k] < kInf)) {
      return {0, "min", k, "BOX_NOT_FINITE", "a min must be a number, or nothing for an open side"};
    }
    if (!(box.max[k] > -kInf)) {
      return {0, "max", k, "BOX_NOT_FINITE", "a max must be a number, or nothing for an open side"};
    }
  }
  for (int k = 0; k < 3; ++k) {
    if (box.min[k] > box.max[k]) {
      return {0, "min", k, "BOX_REVERSED", "min must not be larger than max"};
    }
  }
  return {};
}

BoxFault fault_of(const OrientedBox& box) {
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(box.center[k])) {
      return {0, "center", k, "BOX_NOT_FINITE", "a center must be three finite numbers"};
    }
    if (std::isnan(box.half[k])) {
      return {0, "half", k, "BOX_NOT_FINITE",
              "a half must be a number, or nothing for an open side"};
    }
    if (box.half[k] < 0) {
      return {0, "half", k, "BOX_HALF_NEGATIVE", "a half must not be negative"};
    }
  }
  for (int k = 0; k < 3; ++k) {
    const Vec3d& axis = box.axes[static_cast<std::size_t>(k)];
    if (!std::isfinite(axis.x) || !std::isfinite(axis.y) || !std::isfinite(axis.z)) {
      return {0, "axes", k, "BOX_NOT_FINITE", "an axis must be three finite numbers"};
    }
    if (axis.x == 0 && axis.y == 0 && axis.z == 0) {
      return {0, "axes", k, "BOX_AXIS_ZERO", "an axis must not be zero"};
    }
  }
  if (axes_are_dependent(box.axes)) {
    return {0, "axes", BoxFault::kWhole, "BOX_AXES_DEPENDENT",
            "the three axes must not lie in one plane"};
  }
  return {};
}

BoxFault fault_of_point(const Vec3d& p, const char* part) {
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(p[k])) {
      return {0, part, k, "BOX_NOT_FINITE", "a point must be three finite numbers"};
    }
  }
  return {};
}

BoxFault fault_of_radius(double radius) {
  if (!std::isfinite(radius)) {
    return {0, "radius", BoxFault::kWhole, "BOX_NOT_FINITE", "a radius must be finite"};
  }
  if (radius < 0) {
    return {0, "radius", BoxFault::kWhole, "BOX_RADIUS_NEGATIVE", "a radius must not be negative"};
  }
  return {};
}

/// The first one that is a fault.
BoxFault first_of(const BoxFault& a, const BoxFault& b) { return *a.code != '\0' ? a : b; }

BoxFault fault_of(const Sphere& sphere) {
  return first_of(fault_of_point(sphere.center, "center"), fault_of_radius(sphere.radius));
}

BoxFault fault_of(const Capsule& capsule) {
  return first_of(first_of(fault_of_point(capsule.from, "from"), fault_of_point(capsule.to, "to")),
                  fault_of_radius(capsule.radius));
}

BoxFault fault_of(const ConvexRegion& region) {
  if (region.planes.empty() || region.planes.size() > ConvexRegion::kMostPlanes) {
    return {0, "planes", BoxFault::kWhole, "BOX_PLANES_COUNT", "a region has 1 to 32 planes"};
  }
  for (std::size_t i = 0; i < region.planes.size(); ++i) {
    const auto& [normal, offset] = region.planes[i];
    const int at = static_cast<int>(i);
    if (!is_finite(normal) || !std::isfinite(offset)) {
      return {0, "planes", at, "BOX_NOT_FINITE", "a plane must be four finite numbers"};
    }
    if (normal == Vec3d{}) {
      return {0, "planes", at, "BOX_PLANE_ZERO", "a plane's normal must not be zero"};
    }
  }
  return {};
}

BoxFault fault_of(const PointHull& hull) {
  if (hull.points.empty() || hull.points.size() > PointHull::kMostPoints) {
    return {0, "hull", BoxFault::kWhole, "BOX_HULL_COUNT", "a hull has 1 to 256 points"};
  }
  for (std::size_t i = 0; i < hull.points.size(); ++i) {
    if (!is_finite(hull.points[i])) {
      return {0, "hull", static_cast<int>(i), "BOX_NOT_FINITE",
              "a point must be three finite numbers"};
    }
  }
  return {};
}

}  // namespace

void BoxBatch::push_back(const Sphere& sphere) {
  aligned.push_back({});
  oriented.push_back(kSphereShape | static_cast<std::uint32_t>(spheres.size()));
  spheres.push_back(sphere);
}

void BoxBatch::push_back(const Capsule& capsule) {
  aligned.push_back({});
  oriented.push_back(kCapsuleShape | static_cast<std::uint32_t>(capsules.size()));
  capsules.push_back(capsule);
}

void BoxBatch::push_back(const ConvexRegion& region) {
  aligned.push_back({});
  oriented.push_back(kConvexShape | static_cast<std::uint32_t>(first_plane.size() - 1));
  planes.insert(planes.end(), region.planes.begin(), region.planes.end());
  first_plane.push_back(planes.size());
}

void BoxBatch::push_back(const PointHull& hull) {
  aligned.push_back({});
  oriented.push_back(kHullShape | static_cast<std::uint32_t>(first_point.size() - 1));
  points.insert(points.end(), hull.points.begin(), hull.points.end());
  first_point.push_back(points.size());
}

void BoxBatch::push_back(const Box3d& box) {
  aligned.push_back(box);
  oriented.push_back(kAligned);
}

void BoxBatch::push_back(const OrientedBox& box) {
  aligned.push_back({});
  oriented.push_back(static_cast<std::uint32_t>(oriented_boxes.size()));
  oriented_boxes.push_back(box);
}

bool check_boxes(const BoxBatch& boxes, BoxFault& fault) {
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    BoxFault found = boxes.visit(i, [](const auto& box) { return fault_of(box); });
    if (*found.code == '\0') continue;
    found.box = i;
    fault = found;
    return false;
  }
  return true;
}

bool is_rotation(double x, double y, double z, double w) {
  const double length = x * x + y * y + z * z + w * w;
  return length >= 0.99 && length <= 1.01;
}

}  // namespace sightline
