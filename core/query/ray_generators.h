#pragma once
/// Rays made from a few numbers: cameras, scanners, samples of a hemisphere.
/// docs/reference/generators.md has the formulas; with float64 + - * / sqrt alone they give the
/// same rays on every machine.

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

/// Where a sensor is and where it points. `forward` and `up` need not be unit nor orthogonal.
struct Pose {
  Vec3d position;
  Vec3d forward{0, 0, -1};
  Vec3d up{0, 1, 0};
};

/// The axes of a pose: three directions that are unit and at right angles, up to rounding.
struct Frame {
  Vec3d position, forward, left, up;
};
/// Empty where forward is zero, or along up.
std::optional<Frame> frame_of(const Pose& pose);

/// Limits of every ray.
struct RayRange {
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

// Pixels are numbered by rows from the upper left one.

/// The forward part of every direction has length 1: t is the depth.
struct Pinhole {
  Pose pose;
  double fov_y = 60;  ///< degrees, above 0 and below 180
  std::uint64_t width = 0, height = 0;
};

/// Parallel rays; `extent_y` is the height of the image in scene units.
struct Orthographic {
  Pose pose;
  double extent_y = 1;
  std::uint64_t width = 0, height = 0;
};

/// A panorama. The middle of the image is forward, its upper edge is up. Directions are unit.
struct Equirectangular {
  Pose pose;
  std::uint64_t width = 0, height = 0;
};

/// Ray (pose * azimuths + a) * rings + r; azimuth a is 360 a / azimuths degrees from forward to the
/// left. Directions are unit.
struct Lidar {
  std::vector<Pose> poses;
  std::vector<double> elevations;  ///< degrees up, one for each ring
  std::uint64_t azimuths = 0;
};

/// `count` directions on the side of each normal, which need not be unit; ray point * count + i.
struct Hemisphere {
  std::vector<Vec3d> points, normals;  ///< as many
  std::uint64_t count = 0;
  std::uint64_t seed = 0;
  bool uniform = false;     ///< else by the cosine
  std::uint64_t first = 0;  ///< the number of the first point: each number has samples of its own
};

struct RayGenerator {
  std::variant<Pinhole, Orthographic, Equirectangular, Lidar, Hemisphere> kind;
  RayRange range;
  std::uint64_t returns = 1;  ///< how many hits of each ray an answer has slots for
};

/// How many rays it makes; the largest number when that does not fit.
std::uint64_t ray_count(const RayGenerator& generator);

/// Errors: GENERATOR_POSE (forward is zero, or along up), GENERATOR_RANGE (numbers that overflow,
/// or an angle that is none). The rays have passed check_rays. Throws std::bad_alloc.
Result<RayBatch> generate_rays(const RayGenerator& generator);

/// Sine and cosine of an angle in degrees, within 2^-52, exact at multiples of 90; the same bits on
/// every machine, which libm does not promise. Precondition: finite.
struct SinCos {
  double sin = 0, cos = 1;
};
SinCos sin_cos_degrees(double degrees);

}  // namespace sightline

// Tests: tests/unit/proto/ray_json_test.cpp
