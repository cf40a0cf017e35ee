#include "core/trace/ray_setup.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/geometry/rounding.h"

namespace sightline {

namespace {

constexpr double kMaxD = std::numeric_limits<double>::max();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double largest_magnitude(const std::array<double, 3>& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

bool is_known(const AnchoredRay& ray) {
  return std::isfinite(ray.origin[0]) && std::isfinite(ray.origin[1]) &&
         std::isfinite(ray.origin[2]);
}

/// Scales by a power of two so that the largest |component| is in [1, 2); returns the exponent.
/// Precondition: some component is not zero, all are finite.
int normalise(std::array<double, 3>& direction) {
  const int exponent = -std::ilogb(largest_magnitude(direction));
  if (exponent == 0) return 0;
  if (std::abs(exponent) < 1000) {
    const double scale = power_of_two(exponent);
    for (double& d : direction) d *= scale;
  } else {
    for (double& d : direction) d = std::ldexp(d, exponent);
  }
  return exponent;
}

/// A tau that is not above that of any point of the box on the line: the latest entry into a slab,
/// less its rounding errors. Minus the largest float64 if no slab says anything. In tau, whose
/// direction is scaled, a point of the scene cannot be out of range as its t can.
double enter_at_least(const AnchoredRay& ray, const Box3d& bounds) {
  double enter = -kMaxD;
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const double d = ray.direction[axis];
    // A component below the normal range may have been rounded, by half of itself: it says nothing.
    if (std::abs(d) < std::numeric_limits<double>::min()) continue;
    const double plane = d > 0 ? bounds.min[k] : bounds.max[k];
    const double tau = (plane - ray.origin[axis]) / d;
    if (!std::isfinite(tau)) continue;
    enter = std::max(enter, next_below(tau - std::abs(tau) * bounds::kEnter));
  }
  return enter;
}

/// Moves the origin to tau = anchor, in double-double, and bounds what the last rounding lost.
void move_origin(double anchor, AnchoredRay& ray) {
  ray.anchor = anchor;
  for (std::size_t k = 0; k < 3; ++k) {
    const double o = ray.origin[k];
    const double d = ray.direction[k];
    const double product = anchor * d;
    const double product_rest = std::fma(anchor, d, -product);
    const double sum = o + product;
    const double part = sum - o;
    const double sum_rest = (o - (sum - part)) + (product - part);
    const double rest = sum_rest + product_rest;
    // What overflows is unknown, and NaN is how slabs and filters are told so: they exclude
    // nothing.
    ray.origin[k] = std::isfinite(sum + rest) ? sum + rest : kUnknown;
    const double error =
        kU * std::abs(sum + rest) + bounds::kAnchor * (std::abs(o) + std::abs(product)) +
        std::abs(anchor) * bounds::kDirectionFloor + std::numeric_limits<double>::min();
    ray.error = std::max(ray.error, error);
  }
}

/// Slabs for origin and direction in tree units, the origin known up to `pad` on each axis.
BoxRay make_slabs(const std::array<double, 3>& origin, const std::array<double, 3>& direction,
                  const std::array<double, 3>& pad) {
  constexpr float kMax = std::numeric_limits<float>::max();
  constexpr double kMaxFloat = kMax;
  BoxRay box;
  std::array<bool, 3> negative{};
  for (std::size_t k = 0; k < 3; ++k) {
    // To the nearest float32 after a step outwards that is larger than what rounding can undo.
    const double step = std::abs(origin[k]) * bounds::kOriginStep + pad[k];
    const auto below = static_cast<float>(origin[k] - step);
    const auto above = static_cast<float>(origin[k] + step);
    if (!std::isfinite(below) || !std::isfinite(above)) {
      // Too large for float32, or not known at all: on this axis every box passes, but for an empty
      // child (lower = +inf, upper = -inf), whose reference leads nowhere. An infinite or NaN
      // origin would let that through as well.
      box.near_origin[k] = kMax;
      box.far_origin[k] = -kMax;
      box.near_inverse[k] = kMax;
      box.far_inverse[k] = kInfF;
      continue;
    }
    const double inverse = 1 / std::abs(direction[k]);
    const auto near_inverse =
        static_cast<float>(std::min(inverse * (1 - bounds::kInverseStep), kMaxFloat));
    const auto far_inverse = static_cast<float>(inverse * (1 + bounds::kInverseStep));
    negative[k] = std::signbit(direction[k]);
    box.near_origin[k] = negative[k] ? below : above;
    box.far_origin[k] = negative[k] ? above : below;
    box.near_inverse[k] = negative[k] ? -near_inverse : near_inverse;
    box.far_inverse[k] = negative[k] ? -far_inverse : far_inverse;
  }
  box.set_octant(negative[0], negative[1], negative[2]);
  return box;
}

/// Of a tau that is not finite in float64.
Interval beyond_range(bool positive) {
  return positive ? Interval{kMaxD, kInfD} : Interval{-kInfD, -kMaxD};
}

}  // namespace

Interval AnchoredRay::tau_of(double t) const {
  const double from_origin = t * tau_per_t;
  // An infinite t stands for any that rounds to it.
  if (std::isinf(t) && tau_per_t < 1) {
    const double edge = kMaxD * tau_per_t * (1 - 0x1p-40);
    const double other = anchor == 0 ? 0 : std::abs(anchor) * 0x1p-49;
    return t > 0 ? Interval{edge - anchor - other, kInfD}
                 : Interval{-kInfD, -edge - anchor + other};
  }
  if (std::isinf(from_origin)) return beyond_range(from_origin > 0);
  const double tau = from_origin - anchor;
  if (std::isinf(tau)) return beyond_range(tau > 0);
  // At least 2^-1072 * tau_per_t + 2^-1020, without a subnormal product, which takes a hundred cycles.
  const double least = 0x1p-1019 * std::max(1.0, tau_per_t * 0x1p-52);
  const double slack = (std::abs(from_origin) + std::abs(tau)) * 0x1p-49 + least;
  return {tau - slack, tau + slack};
}

bool is_rounded(const Vec3d& direction, const std::array<double, 3>& scaled) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (direction[static_cast<int>(k)] != 0 &&
        std::abs(scaled[k]) < std::numeric_limits<double>::min())
      return true;
  }
  return false;
}

AnchoredRay anchor_ray(const Ray& ray, const Box3d& bounds) {
  AnchoredRay out;
  out.direction = {ray.direction.x, ray.direction.y, ray.direction.z};
  const int exponent = normalise(out.direction);
  out.tau_per_t = exponent == 0 ? 1.0 : std::ldexp(1.0, -exponent);

  const std::array<double, 3> scene{std::max(std::abs(bounds.min.x), std::abs(bounds.max.x)),
                                    std::max(std::abs(bounds.min.y), std::abs(bounds.max.y)),
                                    std::max(std::abs(bounds.min.z), std::abs(bounds.max.z))};
  out.origin = {ray.origin.x, ray.origin.y, ray.origin.z};

  // Rays from far away and rays that begin behind their origin start again at the scene's bounds.
  const bool far = !(largest_magnitude(out.origin) <= 4 * largest_magnitude(scene));
  if (far || ray.tmin < 0) {
    // next_below covers a limit so small that scaling it rounds.
    const double limit = next_below(ray.tmin * out.tau_per_t);
    move_origin(std::max(limit, enter_at_least(out, bounds)), out);
  }

  out.reach = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    out.reach = std::max(out.reach, (std::abs(out.origin[k]) + scene[k]) * (1 + 4 * kU));
  }
  if (is_rounded(ray.direction, out.direction)) {
    out.error += bounds::kDirectionFloor * out.reach;  // |tau| <= reach on the scene
  }
  out.reach = std::max(out.reach, out.error * 0x1p53);

  const auto limit = [&](double t) {
    if (std::isinf(t)) return Interval{t, t};
    const double tau = t * out.tau_per_t;
    if (out.anchor == 0 && (t == 0 || std::abs(tau) >= 0x1p-1000)) return Interval{tau, tau};
    return out.tau_of(t);
  };
  out.tau_min = limit(ray.tmin);
  out.tau_max = limit(ray.tmax);
  return out;
}

FilterRay make_filter_ray(const AnchoredRay& ray) {
  const double x = std::abs(ray.direction[0]);
  const double y = std::abs(ray.direction[1]);
  const double z = std::abs(ray.direction[2]);
  FilterRay filter;
  filter.kz = x >= y ? (x >= z ? 0u : 2u) : (y >= z ? 1u : 2u);
  filter.kx = filter.kz == 2 ? 0 : filter.kz + 1;
  filter.ky = filter.kx == 2 ? 0 : filter.kx + 1;
  filter.inverse_z = 1 / ray.direction[filter.kz];
  filter.shear_x = ray.direction[filter.kx] * filter.inverse_z;
  filter.shear_y = ray.direction[filter.ky] * filter.inverse_z;
  filter.origin[0] = ray.origin[filter.kx];
  filter.origin[1] = ray.origin[filter.ky];
  filter.origin[2] = ray.origin[filter.kz];
  filter.reach = ray.reach <= bounds::kFilterReach ? ray.reach : kInfD;
  filter.tau_min_low = ray.tau_min.low;
  filter.tau_min_high = ray.tau_min.high;
  filter.tau_max_low = ray.tau_max.low;
  return filter;
}

BoxRay make_box_ray(const AnchoredRay& ray, int scale_exponent) {
  const double scale = power_of_two(scale_exponent);
  std::array<double, 3> origin = ray.origin;
  for (double& o : origin) o *= scale;
  const double pad = ray.error * scale + bounds::kPad;
  BoxRay box = make_slabs(origin, ray.direction, {pad, pad, pad});
  // From an unknown origin tau may even be negative: no limit may exclude anything either.
  box.tau_scale = is_known(ray) ? scale : kUnknown;
  box.tau_min = BoxRay::lowest_tau(ray.tau_min.low, box.tau_scale);
  return box;
}

BoxRay make_box_ray(const AnchoredRay& ray, const TreeSpace& space, int scale_exponent) {
  std::array<double, 3> from;
  for (std::size_t j = 0; j < 3; ++j) from[j] = ray.origin[j] - space.translation[j];
  std::array<double, 3> origin;
  std::array<double, 3> direction;
  std::array<double, 3> pad;
  const double scale = power_of_two(scale_exponent);
  double tau_most = 0;  // at least |tau| on the placed triangles
  for (std::size_t j = 0; j < 3; ++j)
    tau_most = std::max(tau_most, std::abs(ray.origin[j]) + space.reach[j]);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& n = space.inverse[k];
    origin[k] = (n[0] * from[0] + n[1] * from[1] + n[2] * from[2]) * scale;
    direction[k] = n[0] * ray.direction[0] + n[1] * ray.direction[1] + n[2] * ray.direction[2];
    double error = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      error += std::abs(n[j]) * (bounds::kMapped * kU * (std::abs(ray.origin[j]) + space.reach[j]) +
                                 1.0000001 * ray.error);
    }
    if (tau_most > bounds::kMappedTau) error += tau_most * bounds::kMappedFloor;
    pad[k] = (space.pad[k] + error) * scale + bounds::kPad;
  }
  if (!(largest_magnitude(direction) > 0) || !std::isfinite(largest_magnitude(direction))) {
    // Nothing is known in this space: boxes cannot exclude anything.
    direction = {1, 1, 1};
    pad = {kInfD, kInfD, kInfD};
  }
  const int exponent = normalise(direction);
  double tau_scale = std::ldexp(scale, -exponent);
  if (!std::isnormal(tau_scale) || !(tau_most * tau_scale <= bounds::kMappedTau) ||
      !is_known(ray)) {
    // The two spaces count t so differently that no float64 relates them: exclude nothing.
    tau_scale = kUnknown;
    pad = {kInfD, kInfD, kInfD};
  }
  BoxRay box = make_slabs(origin, direction, pad);
  box.tau_scale = tau_scale;
  box.tau_min = BoxRay::lowest_tau(ray.tau_min.low, box.tau_scale);
  return box;
}

}  // namespace sightline
