// Double-double arithmetic on vectors, and the intersection of rays and triangles in it.

#if defined(SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#undef SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#else
#define SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#endif

#include <cstddef>

#include "core/trace/bounds.h"
#include "core/trace/kernel/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// A vector of unevaluated sums high + low of two float64, |low| <= ulp(high) / 2. Error bounds:
/// [Joldes2017]. The functions two_* are exact, unless a number overflows or underflows; operators
/// have errors of a few 2^-104, relative to the magnitudes of their operands, or to the product.
template <class Tag>
struct DoubleDoubleOf {
  using D = Tag;
  using V = hn::Vec<D>;
  using DoubleDouble = DoubleDoubleOf;
  V high, low;

  static HWY_INLINE DoubleDouble two_sum(V a, V b) {
    const V s = hn::Add(a, b);
    const V t = hn::Sub(s, a);
    return {s, hn::Add(hn::Sub(a, hn::Sub(s, t)), hn::Sub(b, t))};
  }
  /// a + b, exactly, with fewer operations. Precondition: |a| >= |b| or a is zero.
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
  /// The dot product of a float64 and a double-double vector. The lower parts, of relative size u,
  /// are summed without compensation.
  static HWY_INLINE DoubleDouble dot(const V (&a)[3], const DoubleDouble (&b)[3]) {
    const DoubleDouble p = two_product(a[0], b[0].high), q = two_product(a[1], b[1].high),
                       r = two_product(a[2], b[2].high);
    const DoubleDouble first = two_sum(p.high, q.high);
    const DoubleDouble both = two_sum(first.high, r.high);
    V low = hn::MulAdd(a[0], b[0].low, p.low);
    low = hn::MulAdd(a[1], b[1].low, hn::Add(low, q.low));
    low = hn::MulAdd(a[2], b[2].low, hn::Add(low, r.low));
    return fast_two_sum(both.high, hn::Add(hn::Add(first.low, both.low), low));
  }
  /// True in lanes where `high` is certainly the correct rounding of a number that differs from
  /// high + low by at most `error`. Rounding is monotone, so it suffices that both ends of the
  /// interval round to `high`.
  HWY_INLINE hn::Mask<D> certain(V error) const {
    return hn::And(hn::Eq(hn::Add(high, hn::Add(low, error)), high),
                   hn::Eq(hn::Add(high, hn::Sub(low, error)), high));
  }
};

/// The widest vectors of double-double numbers, of at most eight lanes.
using DoubleDouble = DoubleDoubleOf<hn::CappedTag<double, 8>>;

/// The quotient top / bottom in double-double: q + residual / bottom, where q = top * inverse and
/// residual = top - q bottom. `inverse` is 1 / bottom as a float64.
template <class Tag>
HWY_INLINE DoubleDoubleOf<Tag> quotient_of(const DoubleDoubleOf<Tag>& top,
                                           const DoubleDoubleOf<Tag>& bottom,
                                           hn::Vec<Tag> inverse) {
  const auto q = hn::Mul(top.high, inverse);
#if HWY_NATIVE_FMA
  const auto rest = hn::NegMulAdd(q, bottom.high, top.high);
#else
  const auto p = DoubleDoubleOf<Tag>::two_product(q, bottom.high);
  const auto rest = hn::Sub(hn::Sub(top.high, p.high), p.low);
#endif
  const auto residual = hn::Add(rest, hn::NegMulAdd(q, bottom.low, top.low));
  return DoubleDoubleOf<Tag>::fast_two_sum(q, hn::Mul(residual, inverse));
}
/// A bound for the error of quotient_of, whose result is `value`, if top is off by at most 46 u^2
/// top_size and bottom by at most 43 u^2 bottom_size. u is kU.
template <class Tag>
HWY_INLINE hn::Vec<Tag> error_of_quotient(Tag dd, hn::Vec<Tag> top_size, hn::Vec<Tag> bottom_size,
                                          hn::Vec<Tag> inverse, hn::Vec<Tag> value) {
  const auto size = hn::Abs(value);
  return hn::Mul(hn::Set(dd, bounds::kDoubleDouble),
                 hn::MulAdd(hn::MulAdd(size, bottom_size, top_size), hn::Abs(inverse), size));
}
/// The largest magnitude of a factor for which no product overflows.
constexpr double kLargestFactor = 0x1p300;
/// True in lanes where nothing underflowed or overflowed, so that the error bounds hold.
template <class Tag>
HWY_INLINE hn::Mask<Tag> is_ordinary(Tag dd, hn::Vec<Tag> top_size, hn::Vec<Tag> bottom_size,
                                     hn::Vec<Tag> largest, hn::Vec<Tag> t) {
  const auto small = hn::Set(dd, 0x1p-600);
  return hn::And(hn::And(hn::Ge(top_size, small), hn::Ge(bottom_size, small)),
                 hn::And(hn::Le(largest, hn::Set(dd, kLargestFactor)),
                         hn::Ge(hn::Abs(t), hn::Set(dd, 0x1p-900))));
}

/// Pointers to the columns of rays and of the triangles that they meet. Each column has as many
/// numbers as a vector has lanes, and must outlive the computation.
struct MeetingColumns {
  const double* origin[3];
  const double* direction[3];
  const double* corner[3][3];  ///< [corner][axis], in world space
};

/// The edges of triangles from corner 0, e1 = v1 - v0 and e2 = v2 - v0, exact.
template <class Tag>
struct EdgesOf {
  DoubleDoubleOf<Tag> e1[3], e2[3];

  /// Loads the first lanes of the columns [corner][axis].
  HWY_INLINE explicit EdgesOf(const double* const (&corner)[3][3]) {
    const Tag dd;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v0 = hn::LoadU(dd, corner[0][k]);
      e1[k] = DoubleDoubleOf<Tag>::two_difference(hn::LoadU(dd, corner[1][k]), v0);
      e2[k] = DoubleDoubleOf<Tag>::two_difference(hn::LoadU(dd, corner[2][k]), v0);
    }
  }
};

/// The normals of triangles, not normalised. `size` bounds their errors
/// (docs/explanation/exactness.md, "Rounding t").
template <class Tag>
struct NormalOf {
  using V = hn::Vec<Tag>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  DoubleDouble n[3];  ///< e1 x e2
  V size[3];          ///< n is off by at most 9 u^2 size

  NormalOf() = default;
  HWY_INLINE explicit NormalOf(const EdgesOf<Tag>& edges) {
    const Tag dd;
    const auto& e1 = edges.e1;
    const auto& e2 = edges.e2;
    V rest = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) rest = hn::Or(rest, hn::Or(e1[k].low, e2[k].low));
    // Edges of float32 corners are float64 numbers, but for corners of very different size.
    const bool short_edges = hn::AllTrue(dd, hn::Eq(rest, hn::Zero(dd)));
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      n[k] = short_edges ? DoubleDouble::two_product(e1[i].high, e2[j].high) -
                               DoubleDouble::two_product(e1[j].high, e2[i].high)
                         : e1[i] * e2[j] - e1[j] * e2[i];
      size[k] = hn::Add(hn::Abs(hn::Mul(e1[i].high, e2[j].high)),
                        hn::Abs(hn::Mul(e1[j].high, e2[i].high)));
    }
  }
};

/// The part of the intersection with a plane that depends on the ray's origin, but not on its
/// direction.
template <class Tag>
struct SeenFrom {
  using V = hn::Vec<Tag>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  DoubleDouble a[3];  ///< vector from the origin to corner 0, exact
  DoubleDouble top;   ///< a.n
  V top_size;         ///< bounds the error of top; NaN if a factor is above kLargestFactor

  HWY_INLINE SeenFrom(const NormalOf<Tag>& normal, const double* const (&corner0)[3],
                      const double* const (&origin)[3]) {
    const Tag dd;
    V largest = hn::Zero(dd);
    top_size = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = DoubleDouble::two_difference(hn::LoadU(dd, corner0[k]), hn::LoadU(dd, origin[k]));
      top_size = hn::MulAdd(hn::Abs(a[k].high), normal.size[k], top_size);
      largest = hn::Max(largest, hn::Max(normal.size[k], hn::Abs(a[k].high)));
      top = k == 0 ? a[k] * normal.n[k] : top + a[k] * normal.n[k];
    }
    top_size = hn::IfThenElse(hn::Le(largest, hn::Set(dd, kLargestFactor)), top_size, hn::NaN(dd));
  }
};

/// The intersections of rays with planes: t = top / bottom.
template <class Tag>
struct MeetingOf {
  using D = Tag;
  using V = hn::Vec<D>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  V direction[3];
  DoubleDouble bottom;  ///< d.n
  V bottom_size;        ///< bounds the error of bottom
  V inverse;            ///< 1 / bottom, a float64
  DoubleDouble t;
  V error;               ///< bound of the error of t
  hn::Mask<D> ordinary;  ///< nothing underflowed or overflowed, so that the bounds hold

  /// `top` and `top_size` are those of SeenFrom.
  HWY_INLINE MeetingOf(const NormalOf<Tag>& normal, const DoubleDouble& top, V top_size,
                       const double* const (&directions)[3]) {
    const D dd;
    V largest = hn::Zero(dd);
    bottom_size = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      direction[k] = hn::LoadU(dd, directions[k]);
      const V length = hn::Abs(direction[k]);
      bottom_size = hn::MulAdd(length, normal.size[k], bottom_size);
      largest = hn::Max(largest, length);
    }
    bottom = DoubleDouble::dot(direction, normal.n);
    inverse = hn::Div(hn::Set(dd, 1.0), bottom.high);
    t = quotient(top);
    error = bound(top_size, t.high);
    ordinary = is_ordinary(dd, top_size, bottom_size, largest, t.high);
  }

  /// top / bottom, for another numerator.
  HWY_INLINE DoubleDouble quotient(const DoubleDouble& top) const {
    return quotient_of(top, bottom, inverse);
  }
  /// A bound of the error of quotient(), whose result is `value`.
  HWY_INLINE V bound(V top_size, V value) const {
    return error_of_quotient(D(), top_size, bottom_size, inverse, value);
  }
  /// True in lanes where t.high is certainly the float64 nearest to the exact t.
  HWY_INLINE hn::Mask<D> certain() const { return hn::And(t.certain(error), ordinary); }
};

/// All of the above for several rays and the triangles that they meet.
template <class Tag>
struct IntersectionOf : EdgesOf<Tag>, NormalOf<Tag>, SeenFrom<Tag>, MeetingOf<Tag> {
  using V = hn::Vec<Tag>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  /// Loads the first lanes of the columns.
  HWY_INLINE explicit IntersectionOf(const MeetingColumns& columns)
      : EdgesOf<Tag>(columns.corner),
        NormalOf<Tag>(static_cast<const EdgesOf<Tag>&>(*this)),
        SeenFrom<Tag>(*this, columns.corner[0], columns.origin),
        MeetingOf<Tag>(*this, this->top, this->top_size, columns.direction) {}
};

using Intersection = IntersectionOf<hn::CappedTag<double, 8>>;

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/triangle_setup_cache_test.cpp
