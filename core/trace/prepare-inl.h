// Sets rays up several at a time: the same three views as ray_setup, for the rays that need no new
// origin; the others go through ray_setup itself.

#if defined(SIGHTLINE_TRACE_PREPARE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_PREPARE_INL_H_
#undef SIGHTLINE_TRACE_PREPARE_INL_H_
#else
#define SIGHTLINE_TRACE_PREPARE_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/query/ray_batch.h"
#include "core/trace/ray_setup.h"
#include "core/trace/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// A ray as the kernels carry it through a tree in world units. The AnchoredRay behind it is made
/// again in the rare case that something must be examined.
struct PreparedRay {
  BoxRay box;
  FilterRay filter;
  double tau_max;  ///< upper end of the limit's interval
};

/// Scalar, for any ray.
inline void prepare_one(const Ray& ray, const Box3d& bounds, int scale_exponent, PreparedRay& out) {
  const AnchoredRay anchored = anchor_ray(ray, bounds);
  out.box = make_box_ray(anchored, scale_exponent);
  out.filter = make_filter_ray(anchored);
  out.tau_max = anchored.tau_max.high;
}

/// As many rays at a time as a vector holds, at most kMaxLanes.
template <std::size_t kMaxLanes>
class Preparation {
 public:
  using D = hn::CappedTag<double, kMaxLanes>;

  Preparation(const Box3d& bounds, int scale_exponent)
      : bounds_(bounds), scale_exponent_(scale_exponent), scale_(std::ldexp(1.0, scale_exponent)) {
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k)
      scene_[k] = std::max(std::abs(bounds.min[k]), std::abs(bounds.max[k]));
    far_ = 4 * std::max({scene_[0], scene_[1], scene_[2]});
    // make_filter_ray knows what to do with a scene that large.
    if (!(far_ < bounds::kFilterReach / 2)) far_ = -1;
  }

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

 private:
  HWY_INLINE void prepare_vector(const RayBatch& rays, std::size_t at,
                                 PreparedRay* const* out) const {
    const D dd;
    using V = hn::Vec<D>;
    const hn::Rebind<float, D> df;
    const hn::RebindToUnsigned<D> du;
    const std::size_t lanes = hn::Lanes(dd);

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

    // Rays for ray_setup: far away, with limits behind the origin, of extreme length, or with
    // limits so small that scaling them may round.
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
    const std::uint32_t simple_bits = mask_bits(dd, simple);

    const V one = hn::Set(dd, 1.0);
    const V pad = hn::Set(dd, bounds::kPad);
    V inverse[3];
    V reach = zero;
    HWY_ALIGN float near_origin[3][kMaxLanes], far_origin[3][kMaxLanes];
    HWY_ALIGN float near_inverse[3][kMaxLanes], far_inverse[3][kMaxLanes];
    std::uint32_t negative_bits[3];
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      reach = hn::Max(
          reach, hn::Mul(hn::Add(hn::Abs(o[k]), hn::Set(dd, scene_[k])), hn::Set(dd, 1 + 0x1p-50)));
      const V magnitude = hn::Div(one, hn::Abs(d[k]));
      inverse[k] = hn::CopySign(magnitude, d[k]);
      // To the nearest float32 after a step outwards that is larger than what rounding can undo.
      const V origin = hn::Mul(o[k], hn::Set(dd, scale_));
      const V step = hn::MulAdd(hn::Abs(origin), hn::Set(dd, bounds::kOriginStep), pad);
      const auto below = hn::DemoteTo(df, hn::Sub(origin, step));
      const auto above = hn::DemoteTo(df, hn::Add(origin, step));
      const auto near = hn::DemoteTo(
          df, hn::CopySign(hn::Min(hn::Mul(magnitude, hn::Set(dd, 1 - bounds::kInverseStep)),
                                   hn::Set(dd, 0x1.fffffep127)),
                           d[k]));
      const auto far = hn::DemoteTo(
          df, hn::CopySign(hn::Mul(magnitude, hn::Set(dd, 1 + bounds::kInverseStep)), d[k]));
      const auto negative =
          hn::MaskFromVec(hn::BroadcastSignBit(hn::BitCast(hn::RebindToSigned<D>(), d[k])));
      negative_bits[k] = mask_bits(hn::RebindToSigned<D>(), negative);
      const auto negative_f = hn::Lt(far, hn::Zero(df));
      hn::Store(hn::IfThenElse(negative_f, below, above), df, near_origin[k]);
      hn::Store(hn::IfThenElse(negative_f, above, below), df, far_origin[k]);
      hn::Store(near, df, near_inverse[k]);
      hn::Store(far, df, far_inverse[k]);
    }

    // The axis of the largest component becomes z; ties as in make_filter_ray.
    const V ax = hn::Abs(d[0]), ay = hn::Abs(d[1]), az = hn::Abs(d[2]);
    const auto z_is_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
    const auto z_is_y = hn::AndNot(z_is_x, hn::And(hn::Gt(ay, ax), hn::Ge(ay, az)));
    const auto choose = [&](V if_x, V if_y, V if_z) {
      return hn::IfThenElse(z_is_x, if_x, hn::IfThenElse(z_is_y, if_y, if_z));
    };
    const V inverse_z = choose(inverse[0], inverse[1], inverse[2]);
    HWY_ALIGN double lane_of[9][kMaxLanes];
    hn::Store(choose(o[1], o[2], o[0]), dd, lane_of[0]);
    hn::Store(choose(o[2], o[0], o[1]), dd, lane_of[1]);
    hn::Store(choose(o[0], o[1], o[2]), dd, lane_of[2]);
    hn::Store(hn::Mul(choose(d[1], d[2], d[0]), inverse_z), dd, lane_of[3]);
    hn::Store(hn::Mul(choose(d[2], d[0], d[1]), inverse_z), dd, lane_of[4]);
    hn::Store(inverse_z, dd, lane_of[5]);
    hn::Store(reach, dd, lane_of[6]);
    hn::Store(tau_min, dd, lane_of[7]);
    hn::Store(tau_max, dd, lane_of[8]);
    const std::uint32_t x_bits = mask_bits(dd, z_is_x);
    const std::uint32_t y_bits = mask_bits(dd, z_is_y);
    HWY_ALIGN float box_min[kMaxLanes];
    hn::Store(hn::DemoteTo(df, hn::Mul(tau_min, hn::Set(dd, scale_ * (1 - bounds::kLimitStep)))),
              df, box_min);

    for (std::size_t i = 0; i < lanes; ++i) {
      PreparedRay& ray = *out[i];
      if (HWY_UNLIKELY((simple_bits >> i & 1u) == 0)) {
        prepare_one(rays[at + i], bounds_, scale_exponent_, ray);
        continue;
      }
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        ray.box.near_origin[k] = near_origin[k][i];
        ray.box.far_origin[k] = far_origin[k][i];
        ray.box.near_inverse[k] = near_inverse[k][i];
        ray.box.far_inverse[k] = far_inverse[k][i];
        ray.filter.origin[k] = lane_of[k][i];
      }
      ray.box.set_octant(negative_bits[0] >> i & 1u, negative_bits[1] >> i & 1u,
                         negative_bits[2] >> i & 1u);
      ray.box.tau_min = box_min[i];
      ray.box.tau_scale = scale_;
      ray.filter.shear_x = lane_of[3][i];
      ray.filter.shear_y = lane_of[4][i];
      ray.filter.inverse_z = lane_of[5][i];
      ray.filter.reach = lane_of[6][i];
      ray.filter.tau_min_low = ray.filter.tau_min_high = lane_of[7][i];
      ray.filter.tau_max_low = ray.tau_max = lane_of[8][i];
      const std::uint32_t is_x = x_bits >> i & 1u;
      const std::uint32_t is_y = y_bits >> i & 1u;
      ray.filter.kz = 2 - 2 * is_x - is_y;
      ray.filter.kx = is_x + 2 * is_y;
      ray.filter.ky = 1 + is_x - is_y;
    }
  }

  const Box3d& bounds_;
  int scale_exponent_;
  double scale_;
  double scene_[3];
  double far_;
};

constexpr std::size_t kGroupRays = 8;
using GroupPreparation = Preparation<kGroupRays>;
/// For requests of one ray: the same arithmetic in one lane.
using SinglePreparation = Preparation<1>;

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
