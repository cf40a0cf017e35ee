#include "core/query/ray_generators.h"

#include <cmath>
#include <limits>
#include <optional>

#include "core/base/split_mix.h"
#include "core/geometry/triangle.h"
#include "core/query/vector_arithmetic.h"

namespace sightline {

namespace {

Vec3d operator*(double s, const Vec3d& a) { return {s * a.x, s * a.y, s * a.z}; }
Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

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

template <class Camera>
double aspect_of(const Camera& camera) {
  return static_cast<double>(camera.width) / static_cast<double>(camera.height);
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

/// A point of the open unit disc, by rejection.
void draw_from_disc(SplitMix& numbers, double& x, double& y) {
  do {
    x = 2 * numbers.unit() - 1;
    y = 2 * numbers.unit() - 1;
  } while (!(x * x + y * y < 1));
}

struct OriginAndDirection {
  Vec3d origin, direction;
};

/// ray_of_point(camera, frame)(x, y) is the ray through a point of the picture, in [-1, 1], right
/// and up.
auto ray_of_point(const Pinhole& camera, const Frame& frame) {
  const SinCos half = sin_cos_degrees(camera.fov_x.value_or(camera.fov_y) / 2);
  const double tangent = half.sin / half.cos;
  const double x_aspect = camera.fov_x ? 1 : aspect_of(camera);
  const double y_aspect = camera.fov_x ? aspect_of(camera) : 1;
  return [=](double x, double y) -> OriginAndDirection {
    return {frame.position, frame.forward + (-x * tangent * x_aspect) * frame.left +
                                (y * tangent / y_aspect) * frame.up};
  };
}
auto ray_of_point(const Orthographic& camera, const Frame& frame) {
  const double half = camera.extent_y / 2, aspect = aspect_of(camera);
  return [=](double x, double y) -> OriginAndDirection {
    return {frame.position + (-x * half * aspect) * frame.left + (y * half) * frame.up,
            frame.forward};
  };
}
auto ray_of_point(const Equirectangular&, const Frame& frame) {
  return [=](double x, double y) -> OriginAndDirection {
    return {frame.position, around(frame, sin_cos_degrees(-180 * x), sin_cos_degrees(90 * y))};
  };
}

/// Calls use(ray_of_pixel), where ray_of_pixel(row, column) is the ray through the middle of the
/// pixel.
template <class Camera, class Use>
void with_ray_of_pixel(const Camera& camera, const Frame& frame, const Use& use) {
  if constexpr (requires { camera.intrinsics; }) {
    if (camera.intrinsics) {
      const Intrinsics lens = *camera.intrinsics;
      return use([&frame, lens](std::uint64_t row, std::uint64_t column) -> OriginAndDirection {
        const double x = (static_cast<double>(column) + 0.5 - lens.cx) / lens.fx;
        const double y = (static_cast<double>(row) + 0.5 - lens.cy) / lens.fy;
        return {frame.position, frame.forward + -x * frame.left + -y * frame.up};
      });
    }
  }
  use([w = static_cast<double>(camera.width), h = static_cast<double>(camera.height),
       ray = ray_of_point(camera, frame)](std::uint64_t row, std::uint64_t column) {
    return ray(2 * (static_cast<double>(column) + 0.5) / w - 1,
               1 - 2 * (static_cast<double>(row) + 0.5) / h);
  });
}

/// The directions of a pulse: its axis, then directions that fill a cone around it, by a spiral
/// [Vogel1979].
struct Pulse {
  Vec3d axis, left, up;

  Pulse(const Frame& frame, const SinCos& azimuth, const SinCos& elevation)
      : axis(around(frame, azimuth, elevation)),
        left(azimuth.cos * frame.left + -azimuth.sin * frame.forward),
        up(cross(axis, left)) {}
  Vec3d sample(const Lidar& lidar, std::uint64_t s) const {
    constexpr double kGoldenAngle = 137.50776405003785;
    if (s == 0) return axis;
    const SinCos half = sin_cos_degrees(lidar.divergence / 2);
    const SinCos turn = sin_cos_degrees(kGoldenAngle * static_cast<double>(s));
    const double radius =
        half.sin / half.cos *
        std::sqrt(static_cast<double>(s) / static_cast<double>(lidar.samples - 1));
    const Vec3d direction = axis + (radius * turn.cos) * left + (radius * turn.sin) * up;
    return unit(direction).value_or(axis);
  }
};

/// Calls add(origin, direction) for each ray; nothing if a pose is none.
struct Generate {
  const RayGenerator& generator;

  template <class Camera, class Add>
  bool rays(const Camera& camera, Add add) const {
    const auto frame = frame_of(camera.pose);
    if (!frame) return false;
    with_ray_of_pixel(camera, *frame, [&](const auto& ray) {
      const auto add_pixel = [&](std::uint64_t row, std::uint64_t column) {
        const OriginAndDirection made = ray(row, column);
        add(made.origin, made.direction);
      };
      if (generator.pixels) {
        for (const Pixel& pixel : *generator.pixels) add_pixel(pixel.row, pixel.column);
        return;
      }
      const Crop crop = generator.crop.value_or(Crop{0, 0, camera.width, camera.height});
      for (std::uint64_t row = 0; row < crop.height; ++row) {
        for (std::uint64_t column = 0; column < crop.width; ++column)
          add_pixel(crop.top + row, crop.left + column);
      }
    });
    return true;
  }
  template <class Add>
  bool rays(const Lidar& lidar, Add add) const {
    std::vector<SinCos> elevations;
    for (const Laser& laser : lidar.lasers) elevations.push_back(sin_cos_degrees(laser.elevation));
    for (const Pose& pose : lidar.poses) {
      const auto frame = frame_of(pose);
      if (!frame) return false;
      for (std::uint64_t a = 0; a < lidar.azimuths; ++a) {
        const double step =
            (lidar.to - lidar.from) * static_cast<double>(a) / static_cast<double>(lidar.azimuths);
        for (std::size_t k = 0; k < lidar.lasers.size(); ++k) {
          const SinCos azimuth = sin_cos_degrees(lidar.from + step + lidar.lasers[k].azimuth);
          const Pulse pulse(*frame, azimuth, elevations[k]);
          for (std::uint64_t s = 0; s < lidar.samples; ++s)
            add(pose.position, pulse.sample(lidar, s));
        }
      }
    }
    return true;
  }
  template <class Add>
  bool rays(const Hemisphere& samples, Add add) const {
    for (std::size_t p = 0; p < samples.points.size(); ++p) {
      const auto normal = unit(samples.normals[p]);
      if (!normal) return false;
      // The axis that is the farthest from the normal.
      const Vec3d size{std::fabs(normal->x), std::fabs(normal->y), std::fabs(normal->z)};
      const Vec3d axis = size.x <= size.y && size.x <= size.z ? Vec3d{1, 0, 0}
                         : size.y <= size.z                   ? Vec3d{0, 1, 0}
                                                              : Vec3d{0, 0, 1};
      const Vec3d a = *unit(cross(axis, *normal)), b = cross(*normal, a);
      SplitMix numbers = stream_of(samples.seed, samples.first + p);
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
};

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kMost / b ? kMost : a * b;
}

std::uint64_t count_of(const Lidar& lidar) {
  return product(product(product(lidar.poses.size(), lidar.azimuths), lidar.lasers.size()),
                 lidar.samples);
}
std::uint64_t count_of(const Hemisphere& samples) {
  return product(samples.points.size(), samples.count);
}
template <class Camera>
std::uint64_t count_of(const Camera& camera) {
  return product(camera.width, camera.height);
}

Status check_made(const RayBatch& rays) {
  RayFault fault;
  if (check_rays(rays, fault)) return success();
  return Error{ErrorKind::kInvalid, "GENERATOR_RANGE",
               "ray " + std::to_string(fault.ray) + " that this makes is none: " + fault.message,
               "/generator"};
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

std::optional<Crop> image_of(const RayGenerator& generator) {
  if (generator.crop || generator.pixels) return generator.crop;
  return std::visit(
      [](const auto& kind) -> std::optional<Crop> {
        if constexpr (requires { kind.width; }) return Crop{0, 0, kind.width, kind.height};
        return std::nullopt;
      },
      generator.kind);
}

std::uint64_t ray_count(const RayGenerator& generator) {
  if (generator.pixels) return generator.pixels->size();
  if (generator.crop) return product(generator.crop->width, generator.crop->height);
  return std::visit([](const auto& kind) { return count_of(kind); }, generator.kind);
}

Result<RayBatch> generate_rays(const RayGenerator& generator) {
  RayBatch rays;
  rays.reserve(ray_count(generator));
  const bool has_poses = std::visit(
      [&](const auto& kind) {
        return Generate{generator}.rays(kind, [&](const Vec3d& origin, const Vec3d& direction) {
          rays.push_back({origin, direction, generator.range.tmin, generator.range.tmax});
        });
      },
      generator.kind);
  if (!has_poses) return pose_error();
  Status status = check_made(rays);
  return status ? Result<RayBatch>(std::move(rays)) : status.error();
}

Status generate_rows(const RayGenerator& camera, std::uint64_t begin, std::uint64_t end,
                     RayBatch& rays) {
  return std::visit(
      [&](const auto& kind) -> Status {
        if constexpr (requires { kind.width; }) {
          const auto frame = frame_of(kind.pose);
          if (!frame) return pose_error();
          const Crop crop = camera.crop.value_or(Crop{0, 0, kind.width, kind.height});
          rays.resize(crop.width * (end - begin));
          with_ray_of_pixel(kind, *frame, [&](const auto& ray) {
            std::size_t i = 0;
            for_each_pixel(crop.width, begin, end, [&](std::uint64_t row, std::uint64_t column) {
              const OriginAndDirection made = ray(crop.top + row, crop.left + column);
              rays.set(i++, {made.origin, made.direction, camera.range.tmin, camera.range.tmax});
            });
          });
          return check_made(rays);
        } else {
          return Error{ErrorKind::kInternal, "INTERNAL", "this generator has no pixels", ""};
        }
      },
      camera.kind);
}

}  // namespace sightline
