#include "tests/contestants/unrounded_kernel.h"

#include <limits>

#include "core/trace/kernel/targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/contestants/unrounded_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.
#include <hwy/highway.h>

#include "core/trace/kernel/batch_scheduler-inl.h"
#include "tests/contestants/triangle_tests-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::contestants {
namespace HWY_NAMESPACE {

namespace product = sightline::HWY_NAMESPACE;

/// Takes winners like the product's TRounding, eight at a time, and computes t = n.(v0 - o) / n.d.
class PlainDivision {
 public:
  PlainDivision(const RayBatch& rays, HitBatch& hits) : rays_(rays), hits_(hits) {}

  void add(std::size_t ray, const Candidate& winner) {
    const TriangleId id = winner.id();
    hits_.instance[ray] = id.instance;
    hits_.triangle[ray] = id.triangle;
    ray_[size_] = ray;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3f corner = winner.block->corner(c, winner.lane);
      for (int k = 0; k < 3; ++k) corner_[c][k][size_] = static_cast<double>(corner[k]);
    }
    const double o[3] = {rays_.ox[ray], rays_.oy[ray], rays_.oz[ray]};
    const double d[3] = {rays_.dx[ray], rays_.dy[ray], rays_.dz[ray]};
    for (std::size_t k = 0; k < 3; ++k) {
      origin_[k][size_] = o[k];
      direction_[k][size_] = d[k];
    }
    if (++size_ == kGroup) flush();
  }

  void flush() {
    const hn::CappedTag<double, kGroup> d;
    HWY_ALIGN double t[kGroup];
    for (std::size_t i = 0; i < size_; i += hn::Lanes(d)) {
      const auto load = [&](const Columns& columns) {
        return Vectors<hn::Vec<decltype(d)>>{
            hn::Load(d, columns[0] + i), hn::Load(d, columns[1] + i), hn::Load(d, columns[2] + i)};
      };
      const auto v0 = load(corner_[0]);
      const auto normal = cross(minus(load(corner_[1]), v0), minus(load(corner_[2]), v0));
      const auto top = dot(normal, minus(v0, load(origin_)));
      hn::Store(hn::Div(top, dot(normal, load(direction_))), d, t + i);
    }
    for (std::size_t i = 0; i < size_; ++i) hits_.t[ray_[i]] = t[i];
    size_ = 0;
  }

 private:
  static constexpr std::size_t kGroup = 8;
  using Columns = double[3][kGroup];

  const RayBatch& rays_;
  HitBatch& hits_;
  std::size_t size_ = 0;
  std::size_t ray_[kGroup];
  // Lanes beyond the last winner compute with what an earlier one left.
  HWY_ALIGN Columns corner_[3] = {};
  HWY_ALIGN Columns origin_ = {};
  HWY_ALIGN Columns direction_ = {};
};

void closest_unrounded(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                       HitBatch& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    hits.t[i] = std::numeric_limits<double>::infinity();
    hits.instance[i] = hits.triangle[i] = kNone;
  }
  TraceCounts counts;
  PlainDivision rounding(rays, hits);
  product::BatchScheduler<false, product::Layout::kAsItIs>(scene, rays, nullptr, nullptr, counts)
      .run(begin, end, rounding);
  rounding.flush();
}

bool go_together(const Scene& scene) { return product::can_use_packets(scene, 2); }

}  // namespace HWY_NAMESPACE
}  // namespace sightline::contestants
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::contestants {

namespace {

HWY_EXPORT(closest_unrounded);
HWY_EXPORT(go_together);

}  // namespace

TextbookKernel unrounded_kernel() {
  return {"sightline_unrounded", false,
          [](const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
             HitBatch& hits) {
            HWY_DYNAMIC_DISPATCH(closest_unrounded)(scene, rays, begin, end, hits);
          }};
}

bool can_trace_unrounded(const Scene& scene) {
  return can_trace(scene) && HWY_DYNAMIC_DISPATCH(go_together)(scene);
}

}  // namespace sightline::contestants
#endif
