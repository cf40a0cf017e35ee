// Maps rays into the space of a placement's tree, as make_box_ray of ray_setup.h does, but with the
// three axes in the lanes of a vector, or with several rays.

#if defined(SIGHTLINE_TRACE_ENTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_ENTER_INL_H_
#undef SIGHTLINE_TRACE_ENTER_INL_H_
#else
#define SIGHTLINE_TRACE_ENTER_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/bvh/scene_tree.h"
#include "core/trace/kernel/prepare-inl.h"
#include "core/trace/kernel/simd-inl.h"
#include "core/trace/ray_setup.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

#if HWY_MAX_BYTES >= 32
/// Maps a ray into the space of a tree, given by `space`, and sets `box`. Returns false, with `box`
/// unspecified, if numbers are so large or small that make_box_ray must do it. The error bounds are
/// those of docs/explanation/exactness.md, "Instances" and "Boxes".
HWY_INLINE bool map_box_ray(const AnchoredRay& ray, const TreeSpace& space, int scale_exponent,
                            BoxRay& box) {
  const Axes dd;
  using V = hn::Vec<Axes>;
  V origin = hn::Zero(dd), direction = hn::Zero(dd), error = hn::Zero(dd);
  double tau_most = 0;
  SIGHTLINE_UNROLL
  for (std::size_t j = 0; j < 3; ++j) {
    const V n = axes_of(space.inverse[0][j], space.inverse[1][j], space.inverse[2][j]);
    const double seen = std::abs(ray.origin[j]) + space.reach[j];
    tau_most = std::max(tau_most, seen);
    origin = hn::MulAdd(n, hn::Set(dd, ray.origin[j] - space.translation[j]), origin);
    direction = hn::MulAdd(n, hn::Set(dd, ray.direction[j]), direction);
    error = hn::MulAdd(hn::Abs(n), hn::Set(dd, bounds::kMapped * kU * seen + 1.0000001 * ray.error),
                       error);
  }
  const double largest = hn::GetLane(hn::MaxOfLanes(dd, hn::Abs(direction)));
  // NaN passes no comparison.
  if (!(largest >= 0x1p-400 && largest <= 0x1p400 && tau_most <= 0x1p300)) return false;

  const double scale = power_of_two(scale_exponent);
  const auto exponent = std::bit_cast<std::uint64_t>(largest) & 0x7ff0000000000000ull;
  const double per_tree = std::bit_cast<double>(exponent);
  const double shrink = std::bit_cast<double>((2046ull << 52) - exponent);
  direction = hn::Mul(direction, hn::Set(dd, shrink));
  const V pad = hn::MulAdd(hn::Add(axes_of(space.pad[0], space.pad[1], space.pad[2]), error),
                           hn::Set(dd, scale * (1 + 0x1p-40)), hn::Set(dd, bounds::kPad));
  // What does not fit float32 excludes nothing: make_box_ray knows how.
  if (!set_slabs(hn::Mul(origin, hn::Set(dd, scale)), direction,
                 hn::Div(hn::Set(dd, 1.0), hn::Abs(direction)), pad, box))
    return false;
  box.tau_scale = scale * per_tree;
  box.tau_min = BoxRay::lowest_tau(ray.tau_min.low, box.tau_scale);
  return true;
}
#endif

/// The members of AnchoredRay that mapping needs, for a ray that was set up as `prepared`. `bounds`
/// are those of the scene.
HWY_INLINE AnchoredRay anchored(const Ray& ray, const PreparedRay& prepared, const Box3d& bounds) {
  if (HWY_UNLIKELY(!prepared.simple)) return anchor_ray(ray, bounds);
  const Vec3d& d = ray.direction;
  const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  const auto exponent = std::bit_cast<std::uint64_t>(largest) & 0x7ff0000000000000ull;
  const double shrink = std::bit_cast<double>((2046ull << 52) - exponent);
  AnchoredRay out;
  out.origin = {ray.origin.x, ray.origin.y, ray.origin.z};
  out.direction = {d.x * shrink, d.y * shrink, d.z * shrink};
  out.tau_min.low = prepared.filter.tau_min_low;
  if (HWY_UNLIKELY(is_rounded(d, out.direction))) return anchor_ray(ray, bounds);
  return out;
}

/// Sets `box` to the ray for the tree of a placement, `tree`. `top` is the ray in the units of the
/// top tree.
HWY_INLINE void enter_placement(const AnchoredRay& ray, const Placement& placement,
                                const WideTree& tree, const WideTree& top_tree, const BoxRay& top,
                                BoxRay& box) {
  if (placement.world_boxes) {
    box = tree.scale_exponent == top_tree.scale_exponent ? top
                                                         : make_box_ray(ray, tree.scale_exponent);
    return;
  }
#if HWY_MAX_BYTES >= 32
  if (HWY_LIKELY(map_box_ray(ray, placement.space, tree.scale_exponent, box))) return;
#endif
  box = make_box_ray(ray, placement.space, tree.scale_exponent);
}

/// The members of AnchoredRay that mapping needs, as columns, for rays whose origin need not move.
/// The pointers refer to arrays of kRays numbers.
template <std::size_t kRays>
struct AnchoredColumns {
  const double* origin[3];
  HWY_ALIGN double direction[3][kRays];
  const double* tau_min;

  /// Sets the direction of lane i. Returns false if scaling the direction rounds a component.
  bool set_direction(std::size_t i, const Vec3d& d) {
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    const auto exponent = std::bit_cast<std::uint64_t>(largest) & 0x7ff0000000000000ull;
    const double shrink = std::bit_cast<double>((2046ull << 52) - exponent);
    const std::array<double, 3> scaled{d.x * shrink, d.y * shrink, d.z * shrink};
    for (std::size_t k = 0; k < 3; ++k) direction[k][i] = scaled[k];
    return !is_rounded(d, scaled);
  }
};

/// make_box_ray for the rays from lane i on, as many as a vector has lanes. Sets these lanes of
/// `slabs` and tau_scale. `scale` is 2^scale_exponent of the tree. Returns a bit set: bit j is set
/// if lane i + j is valid; other lanes need make_box_ray. The error bounds are those of
/// map_box_ray.
template <class D, std::size_t kRays>
HWY_INLINE std::uint32_t map_lanes(D dd, const AnchoredColumns<kRays>& rays, std::size_t i,
                                   const TreeSpace& space, double scale, SlabColumns<kRays>& slabs,
                                   double* tau_scale) {
  using V = hn::Vec<D>;
  const hn::Rebind<float, D> df;
  const hn::RebindToUnsigned<D> du;
  V from[3], seen[3], along[3], direction[3];
  V tau_most = hn::Zero(dd), largest = hn::Zero(dd);
  SIGHTLINE_UNROLL
  for (std::size_t j = 0; j < 3; ++j) {
    const V origin = hn::LoadU(dd, rays.origin[j] + i);
    from[j] = hn::Sub(origin, hn::Set(dd, space.translation[j]));
    seen[j] = hn::Add(hn::Abs(origin), hn::Set(dd, space.reach[j]));
    tau_most = hn::Max(tau_most, seen[j]);
    along[j] = hn::Load(dd, rays.direction[j] + i);
  }
  const auto row = [&](double x, double y, double z, const V(&v)[3]) {
    return hn::MulAdd(hn::Set(dd, z), v[2],
                      hn::MulAdd(hn::Set(dd, y), v[1], hn::Mul(hn::Set(dd, x), v[0])));
  };
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& n = space.inverse[k];
    direction[k] = row(n[0], n[1], n[2], along);
    largest = hn::Max(largest, hn::Abs(direction[k]));
  }
  // NaN passes no comparison.
  auto good = hn::And(
      hn::And(hn::Ge(largest, hn::Set(dd, 0x1p-400)), hn::Le(largest, hn::Set(dd, 0x1p400))),
      hn::Le(tau_most, hn::Set(dd, 0x1p300)));
  const auto exponent = hn::And(hn::BitCast(du, largest), hn::Set(du, 0x7ff0000000000000ull));
  const V shrink = hn::BitCast(dd, hn::Sub(hn::Set(du, 2046ull << 52), exponent));
  constexpr double kOff = bounds::kMapped * kU;
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& n = space.inverse[k];
    const V origin = hn::Mul(row(n[0], n[1], n[2], from), hn::Set(dd, scale));
    const V error = row(kOff * std::abs(n[0]), kOff * std::abs(n[1]), kOff * std::abs(n[2]), seen);
    const V pad = hn::MulAdd(hn::Add(hn::Set(dd, space.pad[k]), error),
                             hn::Set(dd, scale * (1 + 0x1p-40)), hn::Set(dd, bounds::kPad));
    const V d = hn::Mul(direction[k], shrink);
    const V step = slabs.set(dd, k, i, origin, d, hn::Div(hn::Set(dd, 1.0), hn::Abs(d)), pad);
    good = hn::And(good, hn::Lt(hn::Add(hn::Abs(origin), step), hn::Set(dd, 0x1p127)));
  }
  const V per_tau = hn::Mul(hn::Set(dd, scale), hn::BitCast(dd, exponent));
  hn::Store(per_tau, dd, tau_scale + i);
  // BoxRay::lowest_tau
  const V tau = hn::Mul(hn::LoadU(dd, rays.tau_min + i), per_tau);
  const auto low =
      to_float32(df, hn::Sub(tau, hn::MulAdd(hn::Abs(tau), hn::Set(dd, bounds::kLimitStep),
                                             hn::Set(dd, bounds::kLimitFloor))));
  hn::Store(hn::IfThenElse(hn::Gt(low, hn::Zero(df)), low, hn::Zero(df)), df, slabs.box_min + i);
  return mask_bits(dd, good);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
