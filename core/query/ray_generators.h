#pragma once
/// Generators of rays: cameras, scanners, and samples of a hemisphere. docs/reference/generators.md
/// has the formulas. They use only float64 + - * / sqrt, so the rays are the same on every machine.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// The place and the orientation of a sensor. `forward` and `up` need not be of length 1 or
/// orthogonal.
struct Pose {
  Vec3d position;
  Vec3d forward{0, 0, -1};
  Vec3d up{0, 1, 0};
};

/// The axes of a pose: orthogonal unit vectors, up to rounding.
struct Frame {
  Vec3d position, forward, left, up;
};
/// Empty if forward is zero, or parallel to up.
std::optional<Frame> frame_of(const Pose& pose);

/// The limits tmin and tmax of every generated ray.
struct RayRange {
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

// Images: pixels are numbered row by row, beginning at the upper left.

/// A perspective camera. The component of every direction along `forward` is 1, so t is the depth.
struct Pinhole {
  Pose pose;
  double fov_y = 60;  ///< degrees, above 0 and below 180
  std::uint64_t width = 0, height = 0;
};

/// A camera with parallel rays; `extent_y` is the height of the image in scene units.
struct Orthographic {
  Pose pose;
  double extent_y = 1;
  std::uint64_t width = 0, height = 0;
};

/// A camera for a panorama of 360 by 180 degrees. The middle of the image is `forward`, its upper
/// edge is `up`. Directions are unit vectors.
struct Equirectangular {
  Pose pose;
  std::uint64_t width = 0, height = 0;
};

/// A rotating scanner with several rings. Ray (pose * azimuths + a) * rings + r has the azimuth 360
/// a / azimuths degrees, from forward to the left, and the elevation r. Directions are unit
/// vectors.
struct Lidar {
  std::vector<Pose> poses;
  /// degrees above the horizontal plane of the pose, one for each ring
  std::vector<double> elevations;
  std::uint64_t azimuths = 0;
};

/// Random directions in the hemisphere around each normal, `count` for each point: ray point *
/// count + i. Normals need not be of length 1.
struct Hemisphere {
  std::vector<Vec3d> points, normals;  ///< of equal sizes
  std::uint64_t count = 0;
  std::uint64_t seed = 0;
  /// true: uniformly distributed; false: with the density of the cosine to the normal
  bool uniform = false;
  /// number of the first point; the samples of a point depend on its number
  std::uint64_t first = 0;
};

/// A request for generated rays.
struct RayGenerator {
  std::variant<Pinhole, Orthographic, Equirectangular, Lidar, Hemisphere> kind;
  RayRange range;
  std::uint64_t returns = 1;  ///< how many hits of each ray the answer has slots for
};

/// The number of rays that generate_rays returns; the largest 64-bit number if it is larger.
std::uint64_t ray_count(const RayGenerator& generator);

/// Generates the rays, which pass check_rays. Errors: GENERATOR_POSE (forward is zero, or parallel
/// to up), GENERATOR_RANGE (a number overflows, or an angle is out of range). Throws
/// std::bad_alloc.
Result<RayBatch> generate_rays(const RayGenerator& generator);

/// Calls pixel(row, column) for rows [begin, end) of an image, in squares of 8 by 8 pixels, so that
/// rays of neighbouring pixels are neighbours in a batch.
template <class Pixel>
void for_each_pixel(std::uint64_t width, std::uint64_t begin, std::uint64_t end, Pixel pixel) {
  constexpr std::uint64_t kSide = 8;
  for (std::uint64_t top = begin; top < end; top += kSide) {
    for (std::uint64_t left = 0; left < width; left += kSide) {
      for (std::uint64_t row = top; row < std::min(end, top + kSide); ++row) {
        for (std::uint64_t column = left; column < std::min(width, left + kSide); ++column)
          pixel(row, column);
      }
    }
  }
}
/// Generates the rays of a camera's rows [begin, end), in the order of for_each_pixel. `rays` is
/// overwritten. Preconditions: the generator has a width and a height, and end <= height. Errors:
/// those of generate_rays. Throws std::bad_alloc.
Status generate_rows(const RayGenerator& camera, std::uint64_t begin, std::uint64_t end,
                     RayBatch& rays);

/// Sine and cosine of an angle in degrees, with an error of at most 2^-52 and exact at multiples of
/// 90. The bits are the same on every machine, which libm does not promise. Precondition: `degrees`
/// is finite.
struct SinCos {
  double sin = 0, cos = 1;
};
SinCos sin_cos_degrees(double degrees);

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
