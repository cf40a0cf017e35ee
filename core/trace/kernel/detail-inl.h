// Computes the properties of hits, in double-double if its error bound suffices, else exactly.
// docs/explanation/exactness.md, "What is asked of a hit".

#if defined(SIGHTLINE_TRACE_DETAIL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_DETAIL_INL_H_
#undef SIGHTLINE_TRACE_DETAIL_INL_H_
#else
#define SIGHTLINE_TRACE_DETAIL_INL_H_
#endif

#include "core/trace/decision.h"
#include "core/trace/kernel/double_double-inl.h"
#include "core/trace/kernel/kernel.h"
#include "core/trace/kernel/normal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Computes position, normal and barycentrics of hits, eight at a time: add() each hit, then
/// flush(). Every number is the exact value rounded once. Lanes for which double-double cannot
/// certify that are computed exactly. The arguments of the constructor must outlive it.
class Details {
 public:
  /// Hits that are computed at a time.
  static constexpr std::size_t kGroup = 8;

  Details(const Scene& scene, const RayBatch& rays, const HitBatch& hits, HitDetail* out,
          TraceCounts& counts)
      : scene_(scene), rays_(rays), hits_(hits), out_(out), counts_(counts) {}

  /// Adds the hit of slot `ray`; writes the results to out[slot] when kGroup hits are collected.
  void add(std::size_t ray) {
    ray_[size_] = ray;
    const Triangle triangle = scene_.world_triangle(hits_.id(ray));
    const Vec3d* corner[3] = {&triangle.v0, &triangle.v1, &triangle.v2};
    const double o[3] = {rays_.ox[ray], rays_.oy[ray], rays_.oz[ray]};
    const double d[3] = {rays_.dx[ray], rays_.dy[ray], rays_.dz[ray]};
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) corner_[c][k][size_] = (*corner[c])[k];
      origin_[k][size_] = o[k];
      direction_[k][size_] = d[k];
    }
    if (++size_ == kGroup) flush();
  }

  /// Writes the results that remain.
  void flush() {
    if (size_ == 0) return;
    for (std::size_t i = size_; i < kGroup; ++i) {
      for (int k = 0; k < 3; ++k) {
        origin_[k][i] = origin_[k][0];
        direction_[k][i] = direction_[k][0];
        for (int c = 0; c < 3; ++c) corner_[c][k][i] = corner_[c][k][0];
      }
    }
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(DoubleDouble::D()))
      certain |= compute(i) << i;
    for (std::size_t i = 0; i < size_; ++i) {
      HitDetail& detail = out_[ray_[i]];
      if ((certain >> i & 1u) != 0) {
        detail.position = {position_[0][i], position_[1][i], position_[2][i]};
        detail.normal = {normal_[0][i], normal_[1][i], normal_[2][i]};
        detail.u = weight_[0][i];
        detail.v = weight_[1][i];
        detail.front = bottom_[i] < 0;
      } else {
        ++counts_.decisions.exact_roundings;
        detail = hit_detail(scene_, rays_[ray_[i]], hits_.id(ray_[i]));
      }
    }
    size_ = 0;
  }

 private:
  using D = DoubleDouble::D;
  using V = DoubleDouble::V;
  using M = hn::Mask<D>;

  /// Computes the lanes from `at` on. Bit i of the result: all numbers of lane at + i are certainly
  /// correctly rounded.
  HWY_INLINE std::uint32_t compute(std::size_t at) {
    const D dd;
    const V zero = hn::Zero(dd);
    const V unit = hn::Set(dd, bounds::kDoubleDouble);
    MeetingColumns columns;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      columns.origin[k] = origin_[k] + at;
      columns.direction[k] = direction_[k] + at;
      SIGHTLINE_UNROLL
      for (std::size_t c = 0; c < 3; ++c) columns.corner[c][k] = corner_[c][k] + at;
    }
    const Intersection meeting(columns);
    const DoubleDouble& t = meeting.t;
    M good = meeting.ordinary;

    // The side: the sign of d.n must be beyond its error.
    good = hn::And(good, hn::Gt(hn::Abs(meeting.bottom.high),
                                hn::Mul(hn::Set(dd, 0x1p-90), meeting.bottom_size)));
    hn::Store(meeting.bottom.high, dd, bottom_ + at);

    // Position = o + d t. In a plane across an axis that coordinate is known.
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const V o = hn::Load(dd, &origin_[k][at]);
      const V v0 = hn::Load(dd, &corner_[0][k][at]);
      const V d = meeting.direction[k];
      const DoubleDouble way = d * t;
      const DoubleDouble p = DoubleDouble{o, zero} + way;
      const V error = hn::MulAdd(hn::Abs(d), meeting.error,
                                 hn::Mul(unit, hn::Add(hn::Abs(o), hn::Abs(way.high))));
      const M flat = hn::And(hn::Eq(v0, hn::Load(dd, &corner_[1][k][at])),
                             hn::Eq(v0, hn::Load(dd, &corner_[2][k][at])));
      const M computed = hn::And(p.certain(error), nowhere_near_underflow(p.high, is_zero(d)));
      good = hn::And(good, hn::Or(flat, computed));
      hn::Store(hn::Add(hn::IfThenElse(flat, v0, p.high), zero), dd, &position_[k][at]);
    }

    // Weights of v1 and v2: d.(e2 x a) and d.(a x e1) over d.n.
    SIGHTLINE_UNROLL
    for (std::size_t w = 0; w < 2; ++w) {
      const DoubleDouble* first = w == 0 ? meeting.e2 : meeting.a;
      const DoubleDouble* second = w == 0 ? meeting.a : meeting.e1;
      DoubleDouble top;
      V top_size = zero;
      M vanishes = hn::Eq(zero, zero);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        const DoubleDouble c = first[i] * second[j] - first[j] * second[i];
        const V size = hn::Add(hn::Abs(hn::Mul(first[i].high, second[j].high)),
                               hn::Abs(hn::Mul(first[j].high, second[i].high)));
        vanishes = hn::And(vanishes, hn::Or(is_zero(meeting.direction[k]),
                                            hn::And(is_zero(first[i].high, second[j].high),
                                                    is_zero(first[j].high, second[i].high))));
        top_size = hn::MulAdd(hn::Abs(meeting.direction[k]), size, top_size);
        top = k == 0 ? meeting.direction[k] * c : top + meeting.direction[k] * c;
      }
      const DoubleDouble weight = meeting.quotient(top);
      const M sized = hn::Or(hn::Ge(top_size, hn::Set(dd, 0x1p-600)), vanishes);
      good = hn::And(good, hn::And(sized, weight.certain(meeting.bound(top_size, weight.high))));
      good = hn::And(good, nowhere_near_underflow(weight.high, vanishes));
      hn::Store(hn::Add(weight.high, zero), dd, &weight_[w][at]);
    }

    double* const normal[3] = {&normal_[0][at], &normal_[1][at], &normal_[2][at]};
    good = hn::And(good, store_unit<D>(meeting, meeting, normal));
    return mask_bits(dd, good);
  }

  const Scene& scene_;
  const RayBatch& rays_;
  const HitBatch& hits_;
  HitDetail* out_;
  TraceCounts& counts_;
  std::size_t size_ = 0;
  std::size_t ray_[kGroup];
  HWY_ALIGN double origin_[3][kGroup];
  HWY_ALIGN double direction_[3][kGroup];
  HWY_ALIGN double corner_[3][3][kGroup];
  HWY_ALIGN double position_[3][kGroup];
  HWY_ALIGN double normal_[3][kGroup];
  HWY_ALIGN double weight_[2][kGroup];
  HWY_ALIGN double bottom_[kGroup];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
