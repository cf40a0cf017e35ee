// Sets up several rays at once: the three forms of ray_setup.h, for rays whose origin need not
// move. Other rays are set up by the functions of ray_setup.h. A simple ray is a ray of the first
// kind.

#if defined(SIGHTLINE_TRACE_PREPARE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_PREPARE_INL_H_
#undef SIGHTLINE_TRACE_PREPARE_INL_H_
#else
#define SIGHTLINE_TRACE_PREPARE_INL_H_
#endif

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/query/ray_batch.h"
#include "core/trace/kernel/simd-inl.h"
#include "core/trace/ray_setup.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// A ray as kernels store it during traversal of a tree in world units. Its AnchoredRay is not
/// stored; it is computed again in the rare cases that need it.
struct PreparedRay {
  BoxRay box;
  FilterRay filter;
  double tau_max;  ///< upper end of the interval of the ray's limit
  bool simple;     ///< origin and limits are the ray's own, and tau is t times a power of two
};

/// Sets up any ray, by the functions of ray_setup.h. `bounds` are those of the scene,
/// `scale_exponent` that of the tree.
inline void prepare_one(const Ray& ray, const Box3d& bounds, int scale_exponent, PreparedRay& out) {
  const AnchoredRay anchored = anchor_ray(ray, bounds);
  out.box = make_box_ray(anchored, scale_exponent);
  out.filter = make_filter_ray(anchored);
  out.tau_max = anchored.tau_max.high;
  out.simple = false;
}

/// A bit set of lanes or rays: bit i is ray i.
using LaneBits = std::uint64_t;

/// The members of BoxRay for several rays, as columns: lane i is a ray.
template <std::size_t kRays>
struct SlabColumns {
  HWY_ALIGN float near_origin[3][kRays], far_origin[3][kRays];
  HWY_ALIGN float near_inverse[3][kRays], far_inverse[3][kRays];
  HWY_ALIGN float box_min[kRays];
  /// Bit i is set if the component of the direction of lane i is negative.
  LaneBits negative[3] = {0, 0, 0};

  /// Sets axis k of the lanes from `lane` on. `origin` is in tree units with an error of at most
  /// `pad`; `direction` is scaled so that its largest component is in [1, 2); `inverse` is 1 /
  /// |direction|. Returns by how much the origin was moved outwards.
  template <class D, class V = hn::Vec<D>>
  HWY_INLINE V set(D dd, std::size_t k, std::size_t lane, V origin, V direction, V inverse, V pad) {
    const hn::Rebind<float, D> df;
    // Rounded to the nearest float32, after a step outwards that is larger than the rounding error.
    const V step = hn::MulAdd(hn::Abs(origin), hn::Set(dd, bounds::kOriginStep), pad);
    const auto below = to_float32(df, hn::Sub(origin, step));
    const auto above = to_float32(df, hn::Add(origin, step));
    const auto near =
        to_float32(df, hn::CopySign(hn::Min(hn::Mul(inverse, hn::Set(dd, 1 - bounds::kInverseStep)),
                                            hn::Set(dd, 0x1.fffffep127)),
                                    direction));
    const auto far = to_float32(
        df, hn::CopySign(hn::Mul(inverse, hn::Set(dd, 1 + bounds::kInverseStep)), direction));
    const hn::RebindToSigned<D> di;
    negative[k] |=
        LaneBits{mask_bits(di, hn::MaskFromVec(hn::BroadcastSignBit(hn::BitCast(di, direction))))}
        << lane;
    const auto negative_f = hn::Lt(far, hn::Zero(df));
    hn::Store(hn::IfThenElse(negative_f, below, above), df, near_origin[k] + lane);
    hn::Store(hn::IfThenElse(negative_f, above, below), df, far_origin[k] + lane);
    hn::Store(near, df, near_inverse[k] + lane);
    hn::Store(far, df, far_inverse[k] + lane);
    return step;
  }
};

/// Several rays set up, as columns: BoxRay and FilterRay of each lane.
template <std::size_t kRays>
struct PreparedColumns : SlabColumns<kRays> {
  HWY_ALIGN double origin[3][kRays];  ///< on the axes kx, ky, kz of each ray
  HWY_ALIGN double shear_x[kRays], shear_y[kRays], inverse_z[kRays], reach[kRays];
  HWY_ALIGN double tau_min[kRays], tau_max[kRays];
  /// bit i: this component of the direction of lane i is the largest
  LaneBits largest_x = 0, largest_y = 0;

  /// The FilterRay of lane i.
  FilterRay filter(std::size_t i) const {
    FilterRay ray;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) ray.origin[k] = origin[k][i];
    ray.shear_x = shear_x[i];
    ray.shear_y = shear_y[i];
    ray.inverse_z = inverse_z[i];
    ray.reach = reach[i];
    ray.tau_min_low = ray.tau_min_high = tau_min[i];
    ray.tau_max_low = tau_max[i];
    set_axes(static_cast<std::uint32_t>(largest_x >> i & 1u),
             static_cast<std::uint32_t>(largest_y >> i & 1u), ray);
    return ray;
  }
  /// Sets kx, ky, kz: is_x is 1 if x is the largest axis, is_y if y is; else both are 0.
  static void set_axes(std::uint32_t is_x, std::uint32_t is_y, FilterRay& ray) {
    ray.kz = 2 - 2 * is_x - is_y;
    ray.kx = is_x + 2 * is_y;
    ray.ky = 1 + is_x - is_y;
  }
};

/// Sets up as many rays at a time as a vector holds, at most kMaxLanes. `bounds`, those of the
/// scene, must outlive the object; `scale_exponent` is that of the tree whose boxes the rays test
/// first.
template <std::size_t kMaxLanes>
class Preparation {
 public:
  using D = hn::CappedTag<double, kMaxLanes>;

  Preparation(const Box3d& bounds, int scale_exponent)
      : bounds_(bounds), scale_exponent_(scale_exponent), scale_(power_of_two(scale_exponent)) {
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k)
      scene_[k] = std::max(std::abs(bounds.min[k]), std::abs(bounds.max[k]));
    far_ = 4 * std::max({scene_[0], scene_[1], scene_[2]});
    // make_filter_ray knows what to do with a scene that large.
    if (!(far_ < bounds::kFilterReach / 2)) far_ = -1;
    // Nor may an origin exceed float32 in tree units, which are chosen for the triangles of the tree:
    // an infinite origin would enter empty children.
    far_ = std::min(far_, 0x1p126 / scale_);
  }

  /// Sets up `count` rays from `begin` on into *out[i].
  void prepare(const RayBatch& rays, std::size_t begin, std::size_t count,
               PreparedRay* const* out) const {
    const D d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      if (i + hn::Lanes(d) <= count) {
        prepare_vector(rays, begin + i, out + i);
      } else {
        for (std::size_t k = i; k < count; ++k) {
          prepare_one(rays[begin + k], bounds_, scale_exponent_, *out[k]);
        }
      }
    }
  }

  /// Sets as many lanes as a vector has, from `lane` on, to the rays from `at` on, which must
  /// exist. Returns a bit set: bit i is set if ray at + i is simple; other rays must be set up by
  /// prepare_one.
  template <std::size_t kRays>
  HWY_INLINE std::uint32_t prepare_columns(const RayBatch& rays, std::size_t at, std::size_t lane,
                                           PreparedColumns<kRays>& out) const {
    const D dd;
    using V = hn::Vec<D>;
    const hn::Rebind<float, D> df;
    const hn::RebindToUnsigned<D> du;

    const V o[3] = {hn::LoadU(dd, &rays.ox[at]), hn::LoadU(dd, &rays.oy[at]),
                    hn::LoadU(dd, &rays.oz[at])};
    V d[3] = {hn::LoadU(dd, &rays.dx[at]), hn::LoadU(dd, &rays.dy[at]),
              hn::LoadU(dd, &rays.dz[at])};
    const V tmin = hn::LoadU(dd, &rays.tmin[at]);
    const V tmax = hn::LoadU(dd, &rays.tmax[at]);

    // A power of two brings the largest |direction component| into [1, 2).
    const V largest = hn::Max(hn::Abs(d[0]), hn::Max(hn::Abs(d[1]), hn::Abs(d[2])));
    const auto exponent = hn::And(hn::BitCast(du, largest), hn::Set(du, 0x7ff0000000000000ull));
    const V tau_per_t = hn::BitCast(dd, exponent);
    const V shrink = hn::BitCast(dd, hn::Sub(hn::Set(du, 2046ull << 52), exponent));
    for (V& component : d) component = hn::Mul(component, shrink);

    // Rays that are left to ray_setup.h: with a far origin, with limits behind the origin, of
    // extreme length, or with limits so small that scaling them may round.
    V most = hn::Max(hn::Abs(o[0]), hn::Max(hn::Abs(o[1]), hn::Abs(o[2])));
    const V tau_min = hn::Mul(tmin, tau_per_t);
    const V tau_max = hn::Mul(tmax, tau_per_t);
    const V tiny = hn::Set(dd, 0x1p-1000);
    const V zero = hn::Zero(dd);
    auto simple = hn::And(hn::Le(most, hn::Set(dd, far_)), hn::Ge(tmin, zero));
    simple = hn::And(simple, hn::And(hn::Ge(largest, hn::Set(dd, 0x1p-1000)),
                                     hn::Le(largest, hn::Set(dd, 0x1p1000))));
    simple = hn::And(simple, hn::Or(hn::Ge(tau_min, tiny), hn::Eq(tmin, zero)));
    simple = hn::And(simple, hn::Ge(tau_max, tiny));

    const V one = hn::Set(dd, 1.0);
    const V pad = hn::Set(dd, bounds::kPad);
    V inverse[3];
    V reach = zero;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      reach = hn::Max(
          reach, hn::Mul(hn::Add(hn::Abs(o[k]), hn::Set(dd, scene_[k])), hn::Set(dd, 1 + 0x1p-50)));
      const V magnitude = hn::Div(one, hn::Abs(d[k]));
      inverse[k] = hn::CopySign(magnitude, d[k]);
      out.set(dd, k, lane, hn::Mul(o[k], hn::Set(dd, scale_)), d[k], magnitude, pad);
    }

    // The axis of the largest component becomes z; ties as in make_filter_ray.
    const V ax = hn::Abs(d[0]), ay = hn::Abs(d[1]), az = hn::Abs(d[2]);
    const auto z_is_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
    const auto z_is_y = hn::AndNot(z_is_x, hn::And(hn::Gt(ay, ax), hn::Ge(ay, az)));
    const auto choose = [&](V if_x, V if_y, V if_z) {
      return hn::IfThenElse(z_is_x, if_x, hn::IfThenElse(z_is_y, if_y, if_z));
    };
    const V inverse_z = choose(inverse[0], inverse[1], inverse[2]);
    hn::Store(choose(o[1], o[2], o[0]), dd, out.origin[0] + lane);
    hn::Store(choose(o[2], o[0], o[1]), dd, out.origin[1] + lane);
    hn::Store(choose(o[0], o[1], o[2]), dd, out.origin[2] + lane);
    hn::Store(hn::Mul(choose(d[1], d[2], d[0]), inverse_z), dd, out.shear_x + lane);
    hn::Store(hn::Mul(choose(d[2], d[0], d[1]), inverse_z), dd, out.shear_y + lane);
    hn::Store(inverse_z, dd, out.inverse_z + lane);
    hn::Store(reach, dd, out.reach + lane);
    hn::Store(tau_min, dd, out.tau_min + lane);
    hn::Store(tau_max, dd, out.tau_max + lane);
    out.largest_x |= LaneBits{mask_bits(dd, z_is_x)} << lane;
    out.largest_y |= LaneBits{mask_bits(dd, z_is_y)} << lane;
    hn::Store(to_float32(df, hn::Mul(tau_min, hn::Set(dd, scale_ * (1 - bounds::kLimitStep)))), df,
              out.box_min + lane);
    return mask_bits(dd, simple);
  }

 private:
  HWY_INLINE void prepare_vector(const RayBatch& rays, std::size_t at,
                                 PreparedRay* const* out) const {
    PreparedColumns<kMaxLanes> columns;
    const std::uint32_t simple = prepare_columns(rays, at, 0, columns);
    for (std::size_t i = 0; i < hn::Lanes(D()); ++i) {
      PreparedRay& ray = *out[i];
      if (HWY_UNLIKELY((simple >> i & 1u) == 0)) {
        prepare_one(rays[at + i], bounds_, scale_exponent_, ray);
        continue;
      }
      ray.simple = true;
      ray.filter = columns.filter(i);
      ray.tau_max = columns.tau_max[i];
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        ray.box.near_origin[k] = columns.near_origin[k][i];
        ray.box.far_origin[k] = columns.far_origin[k][i];
        ray.box.near_inverse[k] = columns.near_inverse[k][i];
        ray.box.far_inverse[k] = columns.far_inverse[k][i];
      }
      const auto negative = [&](std::size_t k) { return (columns.negative[k] >> i & 1u) != 0; };
      ray.box.set_octant(negative(0), negative(1), negative(2));
      ray.box.tau_min = columns.box_min[i];
      ray.box.tau_scale = scale_;
    }
  }

  const Box3d& bounds_;
  int scale_exponent_;
  double scale_;
  double scene_[3];
  double far_;
};

/// Rays that are set up in one step.
constexpr std::size_t kGroupRays = 8;

/// Prefetches `count` rays from `first` on, if the batch has so many. Hardware prefetchers are too
/// slow for eight columns at a time.
HWY_INLINE void fetch_rays(const RayBatch& rays, std::size_t first, std::size_t count) {
  if (rays.size() < first + count) return;
  for (const auto* column :
       {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz, &rays.tmin, &rays.tmax}) {
    for (std::size_t i = 0; i < count; i += 64 / sizeof(double))
      hwy::Prefetch(column->data() + first + i);
  }
}
using GroupPreparation = Preparation<kGroupRays>;

#if HWY_MAX_BYTES >= 32
/// The three axes of a vector in lanes; the fourth lane repeats the third.
using Axes = hn::CappedTag<double, 4>;
HWY_INLINE hn::Vec<Axes> axes_of(double x, double y, double z) {
  // Combined in registers: a vector load right after scalar stores is slow.
  const hn::CappedTag<double, 2> d2;
  return hn::Combine(Axes(), hn::Set(d2, z),
                     hn::InterleaveLower(d2, hn::Set(d2, x), hn::Set(d2, y)));
}

/// Sets the slabs of `box` for an origin in tree units with an error of at most `pad`, and a
/// direction whose largest component is in [1, 2); `inverse` is 1 / |direction|. Returns false, and
/// sets nothing, if the origin exceeds float32.
HWY_INLINE bool set_slabs(hn::Vec<Axes> origin, hn::Vec<Axes> direction, hn::Vec<Axes> inverse,
                          hn::Vec<Axes> pad, BoxRay& box) {
  const Axes dd;
  const hn::Rebind<float, Axes> df;
  const auto size = hn::Abs(origin);
  const auto step = hn::MulAdd(size, hn::Set(dd, bounds::kOriginStep), pad);
  if (!hn::AllTrue(dd, hn::Lt(hn::Add(size, step), hn::Set(dd, 0x1p127)))) return false;
  const auto below = to_float32(df, hn::Sub(origin, step));
  const auto above = to_float32(df, hn::Add(origin, step));
  const auto near =
      to_float32(df, hn::CopySign(hn::Min(hn::Mul(inverse, hn::Set(dd, 1 - bounds::kInverseStep)),
                                          hn::Set(dd, 0x1.fffffep127)),
                                  direction));
  const auto far = to_float32(
      df, hn::CopySign(hn::Mul(inverse, hn::Set(dd, 1 + bounds::kInverseStep)), direction));
  const auto negative = hn::Lt(far, hn::Zero(df));
  hn::StoreU(hn::IfThenElse(negative, below, above), df, box.near_origin.data());
  hn::StoreU(hn::IfThenElse(negative, above, below), df, box.far_origin.data());
  hn::StoreU(near, df, box.near_inverse.data());
  hn::StoreU(far, df, box.far_inverse.data());
  const std::uint32_t bits = mask_bits(df, negative);
  box.set_octant(bits & 1u, bits >> 1 & 1u, bits >> 2 & 1u);
  return true;
}
#endif

/// Sets up a single ray, with a short latency. The arguments are those of Preparation.
class SinglePreparation {
 public:
  SinglePreparation(const Box3d& bounds, int scale_exponent)
      : bounds_(bounds), scale_exponent_(scale_exponent) {}

  /// Sets up any ray of a batch.
  HWY_INLINE void prepare(const RayBatch& rays, std::size_t number, PreparedRay& out) const {
#if HWY_MAX_BYTES >= 32
    if (HWY_LIKELY(prepare_axes(rays, number, out))) return;
#endif
    prepare_one(rays[number], bounds_, scale_exponent_, out);
  }

 private:
#if HWY_MAX_BYTES >= 32
  /// Returns false for rays that Preparation leaves to prepare_one, or if set_slabs fails.
  HWY_INLINE bool prepare_axes(const RayBatch& rays, std::size_t number, PreparedRay& out) const {
    const Axes dd;
    const auto most = [&](hn::Vec<Axes> v) { return hn::GetLane(hn::MaxOfLanes(dd, v)); };
    const auto o = axes_of(rays.ox[number], rays.oy[number], rays.oz[number]);
    const auto d = axes_of(rays.dx[number], rays.dy[number], rays.dz[number]);
    const double tmin = rays.tmin[number], tmax = rays.tmax[number];
    const auto scene = hn::Max(hn::Abs(axes_of(bounds_.min.x, bounds_.min.y, bounds_.min.z)),
                               hn::Abs(axes_of(bounds_.max.x, bounds_.max.y, bounds_.max.z)));
    const auto unscaled_inverse = hn::Div(hn::Set(dd, 1.0), hn::Abs(d));
    const auto largest_of_all = hn::MaxOfLanes(dd, hn::Abs(d));
    const double largest = hn::GetLane(largest_of_all);
    const double far = 4 * most(scene);
    const auto exponent = std::bit_cast<std::uint64_t>(largest) & 0x7ff0000000000000ull;
    const double tau_per_t = std::bit_cast<double>(exponent);
    const double shrink = std::bit_cast<double>((2046ull << 52) - exponent);
    const double tau_min = tmin * tau_per_t;
    const double tau_max = tmax * tau_per_t;
    const bool simple = hn::AllTrue(dd, hn::Le(hn::Abs(o), hn::Set(dd, far))) &&
                        far < bounds::kFilterReach / 2 && tmin >= 0 && largest >= 0x1p-500 &&
                        largest <= 0x1p500 && (tau_min >= 0x1p-1000 || tmin == 0) &&
                        tau_max >= 0x1p-1000;
    if (!simple) return false;
    const double scale = power_of_two(scale_exponent_);
    const auto scaled = hn::Mul(d, hn::Set(dd, shrink));
    // 1 / |scaled|, bit by bit, but that both are infinite sooner or later beyond float32. The
    // division does not wait for the scale.
    const auto inverse = hn::Mul(unscaled_inverse, hn::Set(dd, tau_per_t));
    if (!set_slabs(hn::Mul(o, hn::Set(dd, scale)), scaled, inverse, hn::Set(dd, bounds::kPad),
                   out.box))
      return false;
    out.box.tau_scale = scale;
    out.box.tau_min = BoxRay::lowest_tau(tau_min, scale);
    out.tau_max = tau_max;
    out.simple = true;

    HWY_ALIGN double origin[4], direction[4], inverses[4];
    hn::Store(o, dd, origin);
    hn::Store(scaled, dd, direction);
    hn::Store(hn::CopySign(inverse, scaled), dd, inverses);
    FilterRay& filter = out.filter;
    // The first of the largest components becomes z, as in make_filter_ray.
    filter.kz = static_cast<std::uint32_t>(
        std::countr_zero(mask_bits(dd, hn::Eq(hn::Abs(d), largest_of_all))));
    filter.kx = filter.kz == 2 ? 0 : filter.kz + 1;
    filter.ky = 3 - filter.kz - filter.kx;
    filter.inverse_z = inverses[filter.kz];
    filter.shear_x = direction[filter.kx] * filter.inverse_z;
    filter.shear_y = direction[filter.ky] * filter.inverse_z;
    filter.origin[0] = origin[filter.kx];
    filter.origin[1] = origin[filter.ky];
    filter.origin[2] = origin[filter.kz];
    filter.reach = most(hn::Add(hn::Abs(o), scene)) * (1 + 0x1p-50);
    filter.tau_min_low = filter.tau_min_high = tau_min;
    filter.tau_max_low = tau_max;
    return true;
  }
#endif

  const Box3d& bounds_;
  int scale_exponent_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
