#pragma once
/// Generators of rays: cameras, scanners, and samples of a hemisphere. generate_rays makes all rays
/// at once, generate_rows some rows of an image. docs/reference/generators.md has the formulas.
/// They use only float64 + - * / sqrt, so the rays are the same on every machine.

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

/// The position and the orientation of a sensor, in scene units. `forward` and `up` need not be of
/// length 1 or orthogonal.
struct Pose {
  Vec3d position;
  Vec3d forward{0, 0, -1};
  Vec3d up{0, 1, 0};
};

/// The axes of a pose: orthogonal unit vectors, up to rounding.
struct Frame {
  Vec3d position, forward, left, up;
};
/// Computes the axes of a pose. Empty if forward or up is zero or not finite, or if they are
/// parallel.
std::optional<Frame> frame_of(const Pose& pose);

/// The limits tmin and tmax of every generated ray, in units of the length of its direction.
struct RayRange {
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

// Images have width * height pixels, numbered row by row, beginning at the upper left. Each pixel
// gets one ray through its middle. Preconditions: width and height are not 0.

/// The lens of a perspective camera, in pixels: column and row of the point that `forward` meets,
/// counted from the upper left corner of the image, and focal lengths.
struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;
};

/// A perspective camera. The component of every direction along `forward` is 1, so t is the depth:
/// the distance along `forward`, in scene units.
struct Pinhole {
  Pose pose;
  double fov_y = 60;  ///< vertical field of view in degrees; precondition: above 0, below 180
  std::uint64_t width = 0, height = 0;
  std::optional<double> fov_x = {};           ///< degrees; if set, fov_y does not apply
  std::optional<Intrinsics> intrinsics = {};  ///< if set, no field of view applies
};

/// A camera with parallel rays of unit direction; `extent_y` is the height of the image in scene
/// units.
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

/// A laser of a scanner: degrees to the left of its azimuth, and above the horizontal plane.
struct Laser {
  double azimuth = 0, elevation = 0;
};

/// A rotating scanner with several lasers. Pulse (p * azimuths + a) * lasers + k starts at poses[p].
/// Its azimuth is from + (to - from) a / azimuths + lasers[k].azimuth degrees, from forward to the
/// left; its elevation is that of laser k. Directions are unit vectors. With samples > 1 a pulse has
/// so many rays: ray pulse * samples + s; the first is its axis, the others fill a cone.
struct Lidar {
  std::vector<Pose> poses;
  std::vector<Laser> lasers;
  std::uint64_t azimuths = 0;
  double from = 0, to = 360;  ///< degrees
  double divergence = 0;      ///< degrees: the full angle of the cone
  std::uint64_t samples = 1;
};

/// Errors of measured distances, for the hits of generated rays (range_noise.h).
struct RangeNoise {
  double sigma = 0;    ///< standard deviation in units of t
  double dropout = 0;  ///< probability that a ray has no return, 0 to 1
  std::uint64_t seed = 0;
  bool is_used() const { return sigma > 0 || dropout > 0; }
};

/// A pixel, and a rectangle of pixels, of an image.
struct Pixel {
  std::uint64_t column = 0, row = 0;
};
struct Crop {
  std::uint64_t left = 0, top = 0, width = 0, height = 0;
};

/// Random directions in the hemisphere around each normal, `count` for each point: ray p * count +
/// i starts at points[p]. Normals need not be of length 1. Directions are unit vectors, up to
/// rounding.
struct Hemisphere {
  std::vector<Vec3d> points, normals;  ///< of equal sizes
  std::uint64_t count = 0;             ///< directions for each point
  std::uint64_t seed = 0;
  /// true: uniformly distributed; false: with the density of the cosine to the normal
  bool uniform = false;
  /// The number of points[0]; the samples of a point depend on `seed` and the point's number.
  std::uint64_t first = 0;
};

/// A request for generated rays.
struct RayGenerator {
  std::variant<Pinhole, Orthographic, Equirectangular, Lidar, Hemisphere> kind;
  RayRange range;
  std::uint64_t returns = 1;  ///< hits to report for each ray; does not change the rays
  RangeNoise noise = {};      ///< errors of the reported hits; does not change the rays
  /// Cameras only, one of the two at most: only these pixels, row by row; only these, in this
  /// order. Their rays are those of the whole image.
  std::optional<Crop> crop = {};
  std::optional<std::vector<Pixel>> pixels = {};
};

/// The rectangle of pixels that has rays: the crop or the whole image. Empty if the generator is no
/// camera, or has a list of pixels.
std::optional<Crop> image_of(const RayGenerator& generator);

/// The number of rays that generate_rays returns; 2^64 - 1 if it is larger.
std::uint64_t ray_count(const RayGenerator& generator);

/// Generates the rays; they pass check_rays. Preconditions: those of the generator's type. Errors:
/// GENERATOR_POSE (frame_of is empty for a pose, or a normal is zero or not finite),
/// GENERATOR_RANGE (a ray does not pass check_rays: a number overflows, or tmin > tmax). Throws
/// std::bad_alloc.
Result<RayBatch> generate_rays(const RayGenerator& generator);

/// Calls pixel(row, column) for rows [begin, end) of an image of `width` columns, in squares of 8
/// by 8 pixels, so that rays of neighbouring pixels are neighbours in a batch.
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
/// Generates the rays of rows [begin, end) of image_of(camera), in the order of for_each_pixel.
/// `rays` is overwritten, except for its masks. Preconditions: the generator is a Pinhole,
/// Orthographic or Equirectangular (else the error INTERNAL), it has no list of pixels, and begin <=
/// end <= the height of image_of(camera). Errors: those of
/// generate_rays. Throws std::bad_alloc.
Status generate_rows(const RayGenerator& camera, std::uint64_t begin, std::uint64_t end,
                     RayBatch& rays);

/// The sine and the cosine of an angle.
struct SinCos {
  double sin = 0, cos = 1;
};
/// Sine and cosine of an angle in degrees, with an error of at most 2^-52 and exact at multiples of
/// 90. The bits are the same on every machine, which libm does not promise. Precondition: `degrees`
/// is finite.
SinCos sin_cos_degrees(double degrees);

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
