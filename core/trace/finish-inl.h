// Rounds the t of winners, several at a time, in double-double; what that cannot certify is asked
// of the exact predicate. docs/exactness.md, "Rounding t".

#if defined(SIGHTLINE_TRACE_FINISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_FINISH_INL_H_
#undef SIGHTLINE_TRACE_FINISH_INL_H_
#else
#define SIGHTLINE_TRACE_FINISH_INL_H_
#endif

#include "core/trace/bounds.h"
#include "core/trace/decision.h"
#include "core/trace/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Unevaluated sums high + low of float64 lanes, |low| <= ulp(high) / 2. Error bounds:
/// [Joldes2017].
struct DoubleDouble {
  using D = hn::CappedTag<double, 8>;
  using V = hn::Vec<D>;
  V high, low;

  static HWY_INLINE DoubleDouble two_sum(V a, V b) {
    const V s = hn::Add(a, b);
    const V t = hn::Sub(s, a);
    return {s, hn::Add(hn::Sub(a, hn::Sub(s, t)), hn::Sub(b, t))};
  }
  /// Precondition: |a| >= |b| or a is zero.
  static HWY_INLINE DoubleDouble fast_two_sum(V a, V b) {
    const V s = hn::Add(a, b);
    return {s, hn::Sub(b, hn::Sub(s, a))};
  }
  static HWY_INLINE DoubleDouble two_difference(V a, V b) {
    const V s = hn::Sub(a, b);
    const V t = hn::Sub(s, a);
    return {s, hn::Sub(hn::Sub(a, hn::Sub(s, t)), hn::Add(b, t))};
  }
  static HWY_INLINE DoubleDouble two_product(V a, V b) {
    const V p = hn::Mul(a, b);
#if HWY_NATIVE_FMA
    return {p, hn::MulSub(a, b, p)};
#else
    // [Dekker1971] with Veltkamp's splitting.
    const V splitter = hn::Set(D(), 134217729.0);
    const V ac = hn::Mul(a, splitter);
    const V bc = hn::Mul(b, splitter);
    const V ah = hn::Sub(ac, hn::Sub(ac, a));
    const V bh = hn::Sub(bc, hn::Sub(bc, b));
    const V al = hn::Sub(a, ah);
    const V bl = hn::Sub(b, bh);
    V rest = hn::Sub(hn::Mul(ah, bh), p);
    rest = hn::Add(rest, hn::Mul(ah, bl));
    rest = hn::Add(rest, hn::Mul(al, bh));
    return {p, hn::Add(rest, hn::Mul(al, bl))};
#endif
  }
  friend HWY_INLINE DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble p = two_product(a.high, b.high);
    const V cross = hn::Add(hn::Mul(a.high, b.low), hn::Mul(a.low, b.high));
    return fast_two_sum(p.high, hn::Add(p.low, cross));
  }
  friend HWY_INLINE DoubleDouble operator*(V a, const DoubleDouble& b) {
    const DoubleDouble p = two_product(a, b.high);
    return fast_two_sum(p.high, hn::Add(p.low, hn::Mul(a, b.low)));
  }
  friend HWY_INLINE DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble s = two_sum(a.high, b.high);
    return fast_two_sum(s.high, hn::Add(s.low, hn::Add(a.low, b.low)));
  }
  friend HWY_INLINE DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble s = two_difference(a.high, b.high);
    return fast_two_sum(s.high, hn::Add(s.low, hn::Sub(a.low, b.low)));
  }
};

/// Winners on their way to their slots; rounded in groups.
class Finisher {
 public:
  static constexpr std::size_t kGroup = 8;

  Finisher(const Scene& scene, const RayBatch& rays, HitBatch& hits, DecisionCounts& counts)
      : scene_(scene), rays_(rays), hits_(hits), counts_(counts) {}

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
  using D = DoubleDouble::D;
  using V = DoubleDouble::V;

  Triangle corners(const Candidate& winner) const {
    const auto& c = winner.block->corner;
    const std::uint32_t i = winner.lane;
    const Affine& matrix = scene_.description().instances[winner.instance].world_from_mesh;
    return {matrix.apply(Vec3f{c[0][0][i], c[0][1][i], c[0][2][i]}),
            matrix.apply(Vec3f{c[1][0][i], c[1][1][i], c[1][2][i]}),
            matrix.apply(Vec3f{c[2][0][i], c[2][1][i], c[2][2][i]})};
  }

  /// Fills t_ from lane `at` on; bit i: lane at + i is certainly the nearest float64.
  HWY_INLINE std::uint32_t round(std::size_t at) {
    const D dd;
    const auto load = [&](const double(&field)[3][kGroup], std::size_t k) {
      return hn::Load(dd, &field[k][at]);
    };
    // Edges and the way from origin to corner: exact sums of two.
    DoubleDouble e1[3], e2[3], a[3];
    V direction[3];
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const V v0 = load(corner_[0], k);
      e1[k] = DoubleDouble::two_difference(load(corner_[1], k), v0);
      e2[k] = DoubleDouble::two_difference(load(corner_[2], k), v0);
      a[k] = DoubleDouble::two_difference(v0, load(origin_, k));
      direction[k] = load(direction_, k);
    }
    // T = a.n, D = d.n, and the sums of magnitudes that bound their errors.
    DoubleDouble top, bottom;
    V top_size = hn::Zero(dd), bottom_size = hn::Zero(dd), largest = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const DoubleDouble n = e1[i] * e2[j] - e1[j] * e2[i];
      const V size = hn::Add(hn::Abs(hn::Mul(e1[i].high, e2[j].high)),
                             hn::Abs(hn::Mul(e1[j].high, e2[i].high)));
      top_size = hn::MulAdd(hn::Abs(a[k].high), size, top_size);
      bottom_size = hn::MulAdd(hn::Abs(direction[k]), size, bottom_size);
      largest = hn::Max(largest, hn::Max(size, hn::Max(hn::Abs(a[k].high), hn::Abs(direction[k]))));
      top = k == 0 ? a[k] * n : top + a[k] * n;
      bottom = k == 0 ? direction[k] * n : bottom + direction[k] * n;
    }
    // t = q + r / D with the residual r = T - q D.
    const V q = hn::Div(top.high, bottom.high);
    const DoubleDouble p = DoubleDouble::two_product(q, bottom.high);
    const V residual = hn::Add(hn::Sub(hn::Sub(top.high, p.high), p.low),
                               hn::Sub(top.low, hn::Mul(q, bottom.low)));
    const V inverse = hn::Div(hn::Set(dd, 1.0), bottom.high);
    const DoubleDouble t = DoubleDouble::fast_two_sum(q, hn::Mul(residual, inverse));
    const V error = hn::Mul(hn::Set(dd, bounds::kDoubleDouble),
                            hn::MulAdd(hn::MulAdd(hn::Abs(t.high), bottom_size, top_size),
                                       hn::Abs(inverse), hn::Abs(t.high)));
    const auto same = hn::And(hn::Eq(hn::Add(t.high, hn::Add(t.low, error)), t.high),
                              hn::Eq(hn::Add(t.high, hn::Sub(t.low, error)), t.high));
    // Within these sizes nothing underflows or overflows that the bound would have to know of.
    const V small = hn::Set(dd, 0x1p-600);
    const auto ordinary = hn::And(hn::And(hn::Ge(top_size, small), hn::Ge(bottom_size, small)),
                                  hn::And(hn::Le(largest, hn::Set(dd, 0x1p300)),
                                          hn::Ge(hn::Abs(t.high), hn::Set(dd, 0x1p-900))));
    hn::Store(t.high, dd, t_ + at);
    return mask_bits(dd, hn::And(same, ordinary));
  }

  const Scene& scene_;
  const RayBatch& rays_;
  HitBatch& hits_;
  DecisionCounts& counts_;
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
