// Rounds the t of winners, several at a time, in double-double; what that cannot certify is asked
// of the exact predicate. docs/exactness.md, "Rounding t".

#if defined(SIGHTLINE_TRACE_FINISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_FINISH_INL_H_
#undef SIGHTLINE_TRACE_FINISH_INL_H_
#else
#define SIGHTLINE_TRACE_FINISH_INL_H_
#endif

#include "core/trace/decision.h"
#include "core/trace/double_double-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Winners on their way to their slots; rounded in groups.
class Finisher {
 public:
  static constexpr std::size_t kGroup = 8;

  Finisher(const Scene& scene, const RayBatch& rays, HitBatch& hits, DecisionCounts& counts)
      : scene_(scene), rays_(rays), hits_(hits), counts_(counts) {
    for (const Placement& placement : scene.tree().placements)
      plain_ = plain_ && placement.identity;
  }

  void add(std::size_t ray, const Candidate& winner) {
    ray_[size_] = ray;
    id_[size_] = winner.id();
    const Triangle triangle = corners(winner);
    const Vec3d* corner[3] = {&triangle.v0, &triangle.v1, &triangle.v2};
    SIGHTLINE_UNROLL
    for (int c = 0; c < 3; ++c) {
      SIGHTLINE_UNROLL
      for (int k = 0; k < 3; ++k) corner_[c][k][size_] = (*corner[c])[k];
    }
    const double o[3] = {rays_.ox[ray], rays_.oy[ray], rays_.oz[ray]};
    const double d[3] = {rays_.dx[ray], rays_.dy[ray], rays_.dz[ray]};
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k) {
      origin_[k][size_] = o[k];
      direction_[k][size_] = d[k];
    }
    if (++size_ == kGroup) flush();
  }

  void flush() {
    if (size_ == 0) return;
    const DoubleDouble::D d;
    // Lanes without a winner repeat the first one.
    for (std::size_t i = size_; i < kGroup; ++i) {
      SIGHTLINE_UNROLL
      for (int k = 0; k < 3; ++k) {
        origin_[k][i] = origin_[k][0];
        direction_[k][i] = direction_[k][0];
        SIGHTLINE_UNROLL
        for (int c = 0; c < 3; ++c) corner_[c][k][i] = corner_[c][k][0];
      }
    }
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(d)) certain |= round(i) << i;
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t ray = ray_[i];
      hits_.instance[ray] = id_[i].instance;
      hits_.triangle[ray] = id_[i].triangle;
      if ((certain >> i & 1u) != 0) {
        hits_.t[ray] = t_[i];
      } else {
        ++counts_.exact_roundings;
        hits_.t[ray] = exact_t(scene_, rays_[ray], id_[i]);
      }
    }
    size_ = 0;
  }

 private:
  Triangle corners(const Candidate& winner) const {
    const auto& c = winner.block->corner;
    const std::uint32_t i = winner.lane;
    if (plain_) {
      const auto corner = [&](int k) { return Vec3d{c[k][0][i], c[k][1][i], c[k][2][i]}; };
      return {corner(0), corner(1), corner(2)};
    }
    const Affine& matrix = scene_.description().instances[winner.instance].world_from_mesh;
    return {matrix.apply(Vec3f{c[0][0][i], c[0][1][i], c[0][2][i]}),
            matrix.apply(Vec3f{c[1][0][i], c[1][1][i], c[1][2][i]}),
            matrix.apply(Vec3f{c[2][0][i], c[2][1][i], c[2][2][i]})};
  }

  /// Fills t_ from lane `at` on; bit i: lane at + i is certainly the nearest float64.
  HWY_INLINE std::uint32_t round(std::size_t at) {
    const Intersection meeting(origin_, direction_, corner_, at);
    hn::Store(meeting.t.high, DoubleDouble::D(), t_ + at);
    return mask_bits(DoubleDouble::D(),
                     hn::And(meeting.t.certain(meeting.error), meeting.ordinary));
  }

  const Scene& scene_;
  const RayBatch& rays_;
  HitBatch& hits_;
  DecisionCounts& counts_;
  bool plain_ = true;  ///< all placements leave the corners as they are
  std::size_t size_ = 0;
  std::size_t ray_[kGroup];
  TriangleId id_[kGroup];
  HWY_ALIGN double origin_[3][kGroup];
  HWY_ALIGN double direction_[3][kGroup];
  HWY_ALIGN double corner_[3][3][kGroup];
  HWY_ALIGN double t_[kGroup];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
