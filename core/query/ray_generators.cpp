#include "core/query/ray_generators.h"

#include <cmath>
#include <limits>
#include <optional>

#include "core/base/split_mix.h"
#include "core/geometry/triangle.h"

namespace sightline {

namespace {

Vec3d operator*(double s, const Vec3d& a) { return {s * a.x, s * a.y, s * a.z}; }
Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Nothing for zero and for what is not finite.
std::optional<Vec3d> unit(const Vec3d& a) {
  const double largest = std::fmax(std::fabs(a.x), std::fmax(std::fabs(a.y), std::fabs(a.z)));
  if (!(largest > 0) || !is_finite(a)) return std::nullopt;
  // By a power of two first: squares neither overflow nor vanish.
  const int exponent = -std::ilogb(largest);
  const Vec3d s{std::scalbn(a.x, exponent), std::scalbn(a.y, exponent), std::scalbn(a.z, exponent)};
  const double length = std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z);
  return Vec3d{s.x / length, s.y / length, s.z / length};
}

Error pose_error() {
  return {ErrorKind::kInvalid, "GENERATOR_POSE",
          "forward must not be zero, and up must not be along it", "/generator"};
}

/// `azimuth` to the left of forward, `elevation` up.
Vec3d around(const Frame& frame, const SinCos& azimuth, const SinCos& elevation) {
  return (elevation.cos * azimuth.cos) * frame.forward +
         (elevation.cos * azimuth.sin) * frame.left + elevation.sin * frame.up;
}

/// The numbers of one point of a seed.
SplitMix numbers_of(std::uint64_t seed, std::uint64_t point) {
  return SplitMix(SplitMix(seed).bits() ^ (point * 0x9e3779b97f4a7c15u));
}

/// A point of the open unit disc, by rejection.
void draw_from_disc(SplitMix& numbers, double& x, double& y) {
  do {
    x = 2 * numbers.unit() - 1;
    y = 2 * numbers.unit() - 1;
  } while (!(x * x + y * y < 1));
}

/// Calls add(origin, direction) for each ray; nothing if a pose is none.
struct Generate {
  template <class Add>
  static bool rays(const Pinhole& camera, Add add) {
    const auto frame = frame_of(camera.pose);
    if (!frame) return false;
    const SinCos half = sin_cos_degrees(camera.fov_y / 2);
    const double tangent = half.sin / half.cos;
    pixels(camera.width, camera.height, [&](double x, double y, double aspect) {
      add(frame->position,
          frame->forward + (-x * tangent * aspect) * frame->left + (y * tangent) * frame->up);
    });
    return true;
  }
  template <class Add>
  static bool rays(const Orthographic& camera, Add add) {
    const auto frame = frame_of(camera.pose);
    if (!frame) return false;
    const double half = camera.extent_y / 2;
    pixels(camera.width, camera.height, [&](double x, double y, double aspect) {
      add(frame->position + (-x * half * aspect) * frame->left + (y * half) * frame->up,
          frame->forward);
    });
    return true;
  }
  template <class Add>
  static bool rays(const Equirectangular& camera, Add add) {
    const auto frame = frame_of(camera.pose);
    if (!frame) return false;
    pixels(camera.width, camera.height, [&](double x, double y, double) {
      add(frame->position, around(*frame, sin_cos_degrees(-180 * x), sin_cos_degrees(90 * y)));
    });
    return true;
  }
  template <class Add>
  static bool rays(const Lidar& lidar, Add add) {
    std::vector<SinCos> rings;
    for (const double degrees : lidar.elevations) rings.push_back(sin_cos_degrees(degrees));
    for (const Pose& pose : lidar.poses) {
      const auto frame = frame_of(pose);
      if (!frame) return false;
      for (std::uint64_t a = 0; a < lidar.azimuths; ++a) {
        const SinCos azimuth =
            sin_cos_degrees(360.0 * static_cast<double>(a) / static_cast<double>(lidar.azimuths));
        for (const SinCos& ring : rings) add(pose.position, around(*frame, azimuth, ring));
      }
    }
    return true;
  }
  template <class Add>
  static bool rays(const Hemisphere& samples, Add add) {
    for (std::size_t p = 0; p < samples.points.size(); ++p) {
      const auto normal = unit(samples.normals[p]);
      if (!normal) return false;
      // The axis that is the farthest from the normal.
      const Vec3d size{std::fabs(normal->x), std::fabs(normal->y), std::fabs(normal->z)};
      const Vec3d axis = size.x <= size.y && size.x <= size.z ? Vec3d{1, 0, 0}
                         : size.y <= size.z                   ? Vec3d{0, 1, 0}
                                                              : Vec3d{0, 0, 1};
      const Vec3d a = *unit(cross(axis, *normal)), b = cross(*normal, a);
      SplitMix numbers = numbers_of(samples.seed, samples.first + p);
      for (std::uint64_t i = 0; i < samples.count; ++i) {
        double x = 0, y = 0;
        draw_from_disc(numbers, x, y);
        const double square = x * x + y * y;
        double z = std::sqrt(1 - square);
        if (samples.uniform) {
          // [Marsaglia1972], folded onto one side.
          x *= 2 * z;
          y *= 2 * z;
          z = std::fabs(1 - 2 * square);
        }
        add(samples.points[p], x * a + y * b + z * *normal);
      }
    }
    return true;
  }

 private:
  /// pixel(x, y, aspect): its middle in [-1, 1], right and up.
  template <class Pixel>
  static void pixels(std::uint64_t width, std::uint64_t height, Pixel pixel) {
    const auto w = static_cast<double>(width), h = static_cast<double>(height);
    for (std::uint64_t row = 0; row < height; ++row) {
      for (std::uint64_t column = 0; column < width; ++column) {
        pixel(2 * (static_cast<double>(column) + 0.5) / w - 1,
              1 - 2 * (static_cast<double>(row) + 0.5) / h, w / h);
      }
    }
  }
};

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kMost / b ? kMost : a * b;
}

std::uint64_t count_of(const Lidar& lidar) {
  return product(product(lidar.poses.size(), lidar.azimuths), lidar.elevations.size());
}
std::uint64_t count_of(const Hemisphere& samples) {
  return product(samples.points.size(), samples.count);
}
template <class Camera>
std::uint64_t count_of(const Camera& camera) {
  return product(camera.width, camera.height);
}

}  // namespace

std::optional<Frame> frame_of(const Pose& pose) {
  const auto forward = unit(pose.forward), up = unit(pose.up);
  if (!forward || !up) return std::nullopt;
  const auto left = unit(cross(*up, *forward));
  if (!left) return std::nullopt;
  return Frame{pose.position, *forward, *left, cross(*forward, *left)};
}

SinCos sin_cos_degrees(double degrees) {
  // Exact: remainder and the nearest multiple of 90.
  double rest = std::fmod(degrees, 360.0);
  const double quarter = std::nearbyint(rest / 90.0);
  rest -= quarter * 90.0;
  const double x = rest * 0x1.1df46a2529d39p-6;  // pi / 180
  const double square = x * x;
  // Taylor up to the term that is below 2^-56 for |x| <= pi / 4.
  double sine = 0, cosine = 0;
  for (int k = 17; k >= 3; k -= 2) sine = (1 - sine) * square / (k * (k - 1));
  for (int k = 18; k >= 2; k -= 2) cosine = (1 - cosine) * square / (k * (k - 1));
  const double s = x - x * sine, c = 1 - cosine;
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

std::uint64_t ray_count(const RayGenerator& generator) {
  return std::visit([](const auto& kind) { return count_of(kind); }, generator.kind);
}

Result<RayBatch> generate_rays(const RayGenerator& generator) {
  RayBatch rays;
  rays.reserve(ray_count(generator));
  const bool has_poses = std::visit(
      [&](const auto& kind) {
        return Generate::rays(kind, [&](const Vec3d& origin, const Vec3d& direction) {
          rays.push_back({origin, direction, generator.range.tmin, generator.range.tmax});
        });
      },
      generator.kind);
  if (!has_poses) return pose_error();
  RayFault fault;
  if (check_rays(rays, fault)) return rays;
  return Error{ErrorKind::kInvalid, "GENERATOR_RANGE",
               "ray " + std::to_string(fault.ray) + " that this makes is none: " + fault.message,
               "/generator"};
}

}  // namespace sightline
