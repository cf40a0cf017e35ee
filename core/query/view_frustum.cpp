#include "core/query/view_frustum.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <variant>

#include "core/query/vector_arithmetic.h"

namespace sightline {

namespace {

/// a + s b.
Vec3d along(const Vec3d& a, double s, const Vec3d& b) {
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
Vec3d opposite(const Vec3d& a) { return {-a.x, -a.y, -a.z}; }

bool is_plane(const HalfSpace& plane) {
  return is_finite(plane.normal) && std::isfinite(plane.offset) && plane.normal != Vec3d{};
}

/// The four side planes go through `through`; a normal is a side's direction less `slope` times
/// forward. `reach` is how far they lie from that point.
struct Sides {
  double slope_x = 0, slope_y = 0;
  double reach_x = 0, reach_y = 0;
};

Result<std::vector<HalfSpace>> planes_of(const Pose& pose, const Sides& sides,
                                         const RayRange& range) {
  const auto frame = frame_of(pose);
  if (!frame) {
    return Error{ErrorKind::kInvalid, "GENERATOR_POSE",
                 "forward must not be zero, and up must not be along it", ""};
  }
  std::vector<HalfSpace> planes;
  const auto add = [&](const Vec3d& normal, double reach) {
    planes.push_back({normal, dot(normal, frame->position) + reach});
  };
  add(along(frame->left, -sides.slope_x, frame->forward), sides.reach_x);
  add(along(opposite(frame->left), -sides.slope_x, frame->forward), sides.reach_x);
  add(along(frame->up, -sides.slope_y, frame->forward), sides.reach_y);
  add(along(opposite(frame->up), -sides.slope_y, frame->forward), sides.reach_y);
  add(opposite(frame->forward), -range.tmin);
  if (range.tmax < std::numeric_limits<double>::infinity()) add(frame->forward, range.tmax);
  if (!std::all_of(planes.begin(), planes.end(), is_plane)) {
    return Error{ErrorKind::kInvalid, "VIEW_RANGE", "its planes are not finite", ""};
  }
  return planes;
}

double aspect_of(std::uint64_t width, std::uint64_t height) {
  return static_cast<double>(width) / static_cast<double>(height);
}

struct PlanesOfView {
  const RayRange& range;

  Result<std::vector<HalfSpace>> operator()(const Pinhole& camera) const {
    const SinCos half = sin_cos_degrees(camera.fov_y / 2);
    const double tangent = half.sin / half.cos;
    return planes_of(camera.pose, {tangent * aspect_of(camera.width, camera.height), tangent, 0, 0},
                     range);
  }
  Result<std::vector<HalfSpace>> operator()(const Orthographic& camera) const {
    const double half = camera.extent_y / 2;
    return planes_of(camera.pose, {0, 0, half * aspect_of(camera.width, camera.height), half},
                     range);
  }
  template <class Other>
  Result<std::vector<HalfSpace>> operator()(const Other&) const {
    return Error{ErrorKind::kInvalid, "VIEW_KIND",
                 "a view is what a pinhole or an orthographic camera sees", ""};
  }
};

}  // namespace

Result<std::vector<HalfSpace>> view_frustum(const RayGenerator& camera) {
  return std::visit(PlanesOfView{camera.range}, camera.kind);
}

Result<std::vector<HalfSpace>> frustum_of(const std::array<Vec3d, 8>& corners) {
  constexpr std::size_t kFaces[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<HalfSpace> planes;
  for (const auto& face : kFaces) {
    const Vec3d &a = corners[face[0]], &b = corners[face[1]], &c = corners[face[2]];
    HalfSpace plane;
    plane.normal = cross(minus(b, a), minus(c, a));
    plane.offset = dot(plane.normal, a);
    if (!is_plane(plane)) {
      return Error{ErrorKind::kInvalid, "BOX_CORNERS",
                   "three corners of a face lie on one line, or are too far away", ""};
    }
    int inside = 0, outside = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      if (std::find(std::begin(face), std::end(face), i) != std::end(face)) continue;
      const int side = side_of(plane, corners[i]);
      inside += side < 0;
      outside += side > 0;
    }
    if (outside == 4) plane = {opposite(plane.normal), -plane.offset};
    if (inside != 4 && outside != 4) {
      return Error{ErrorKind::kInvalid, "BOX_CORNERS",
                   "the corners of a face must lie on one side of the opposite face: 0 to 3 go "
                   "around one, 4 to 7 around the other, each behind its like",
                   ""};
    }
    planes.push_back(plane);
  }
  return planes;
}

}  // namespace sightline
