// Double-double arithmetic on lanes, and the intersection of ray and triangle in it.

#if defined(SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#undef SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#else
#define SIGHTLINE_TRACE_DOUBLE_DOUBLE_INL_H_
#endif

#include <cstddef>

#include "core/trace/bounds.h"
#include "core/trace/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Unevaluated sums high + low of float64 lanes, |low| <= ulp(high) / 2. Error bounds:
/// [Joldes2017].
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
  /// high + low correctly rounded is `high`, if no error of up to `error` can change that; bit i:
  /// so it is for lane i. Rounding is monotone: both ends of the interval must round to `high`.
  HWY_INLINE hn::Mask<D> certain(V error) const {
    return hn::And(hn::Eq(hn::Add(high, hn::Add(low, error)), high),
                   hn::Eq(hn::Add(high, hn::Sub(low, error)), high));
  }
};

using DoubleDouble = DoubleDoubleOf<hn::CappedTag<double, 8>>;

/// top / bottom as q + r / bottom with the residual r = top - q bottom; `inverse` is 1 / bottom, a
/// float64.
template <class Tag>
HWY_INLINE DoubleDoubleOf<Tag> quotient_of(const DoubleDoubleOf<Tag>& top,
                                           const DoubleDoubleOf<Tag>& bottom,
                                           hn::Vec<Tag> inverse) {
  const auto q = hn::Div(top.high, bottom.high);
  const auto p = DoubleDoubleOf<Tag>::two_product(q, bottom.high);
  const auto residual =
      hn::Add(hn::Sub(hn::Sub(top.high, p.high), p.low), hn::Sub(top.low, hn::Mul(q, bottom.low)));
  return DoubleDoubleOf<Tag>::fast_two_sum(q, hn::Mul(residual, inverse));
}
/// What such a quotient may be off, if the top is off by at most 24 u^2 top_size and the bottom by
/// as much of its size.
template <class Tag>
HWY_INLINE hn::Vec<Tag> error_of_quotient(Tag dd, hn::Vec<Tag> top_size, hn::Vec<Tag> bottom_size,
                                          hn::Vec<Tag> inverse, hn::Vec<Tag> value) {
  const auto size = hn::Abs(value);
  return hn::Mul(hn::Set(dd, bounds::kDoubleDouble),
                 hn::MulAdd(hn::MulAdd(size, bottom_size, top_size), hn::Abs(inverse), size));
}
/// Whether nothing underflowed or overflowed that the bound would have to know of.
template <class Tag>
HWY_INLINE hn::Mask<Tag> is_ordinary(Tag dd, hn::Vec<Tag> top_size, hn::Vec<Tag> bottom_size,
                                     hn::Vec<Tag> largest, hn::Vec<Tag> t) {
  const auto small = hn::Set(dd, 0x1p-600);
  return hn::And(
      hn::And(hn::Ge(top_size, small), hn::Ge(bottom_size, small)),
      hn::And(hn::Le(largest, hn::Set(dd, 0x1p300)), hn::Ge(hn::Abs(t), hn::Set(dd, 0x1p-900))));
}

/// Rays and the triangles that they meet, side by side: each pointer to as many numbers as a vector
/// holds.
struct MeetingColumns {
  const double* origin[3];
  const double* direction[3];
  const double* corner[3][3];  ///< [corner][axis], in the world
};

/// The planes of triangles as seen from origins: of an intersection all that no direction enters.
/// Sums come with the magnitudes that bound their errors (docs/exactness.md, "Rounding t").
template <class Tag>
struct PlaneOf {
  using D = Tag;
  using V = hn::Vec<D>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  DoubleDouble e1[3], e2[3];  ///< edges from corner 0, exact
  DoubleDouble a[3];          ///< from the origin to corner 0, exact
  DoubleDouble n[3];          ///< e1 x e2
  V size[3];                  ///< n is off by at most 9 u^2 of it
  DoubleDouble top;           ///< a.n
  V top_size;
  V largest;  ///< of all factors

  PlaneOf() = default;
  /// Of the lanes that the columns begin with; asks for no direction.
  HWY_INLINE explicit PlaneOf(const MeetingColumns& columns) {
    const D dd;
    V rest = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const V v0 = hn::LoadU(dd, columns.corner[0][k]);
      e1[k] = DoubleDouble::two_difference(hn::LoadU(dd, columns.corner[1][k]), v0);
      e2[k] = DoubleDouble::two_difference(hn::LoadU(dd, columns.corner[2][k]), v0);
      a[k] = DoubleDouble::two_difference(v0, hn::LoadU(dd, columns.origin[k]));
      rest = hn::Or(rest, hn::Or(e1[k].low, e2[k].low));
    }
    // Edges of float32 corners are float64 numbers, but for corners of very different size.
    const bool short_edges = hn::AllTrue(dd, hn::Eq(rest, hn::Zero(dd)));
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      n[k] = short_edges ? DoubleDouble::two_product(e1[i].high, e2[j].high) -
                               DoubleDouble::two_product(e1[j].high, e2[i].high)
                         : e1[i] * e2[j] - e1[j] * e2[i];
    }
    top_size = largest = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      size[k] = hn::Add(hn::Abs(hn::Mul(e1[i].high, e2[j].high)),
                        hn::Abs(hn::Mul(e1[j].high, e2[i].high)));
      top_size = hn::MulAdd(hn::Abs(a[k].high), size[k], top_size);
      largest = hn::Max(largest, hn::Max(size[k], hn::Abs(a[k].high)));
      top = k == 0 ? a[k] * n[k] : top + a[k] * n[k];
    }
  }
};

/// Where rays from the origins of planes meet them.
template <class Tag>
struct MeetingOf {
  using D = Tag;
  using V = hn::Vec<D>;
  using DoubleDouble = DoubleDoubleOf<Tag>;

  V direction[3];
  DoubleDouble bottom;  ///< d.n
  V bottom_size;
  V inverse;  ///< 1 / bottom, a float64
  DoubleDouble t;
  V error;               ///< of t
  hn::Mask<D> ordinary;  ///< nothing underflowed or overflowed that a bound would have to know of

  HWY_INLINE MeetingOf(const PlaneOf<Tag>& plane, const double* const (&directions)[3]) {
    const D dd;
    V largest = plane.largest;
    bottom_size = hn::Zero(dd);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      direction[k] = hn::LoadU(dd, directions[k]);
      const V length = hn::Abs(direction[k]);
      bottom_size = hn::MulAdd(length, plane.size[k], bottom_size);
      largest = hn::Max(largest, length);
      bottom = k == 0 ? direction[k] * plane.n[k] : bottom + direction[k] * plane.n[k];
    }
    inverse = hn::Div(hn::Set(dd, 1.0), bottom.high);
    t = quotient(plane.top);
    error = bound(plane.top_size, t.high);
    ordinary = is_ordinary(dd, plane.top_size, bottom_size, largest, t.high);
  }

  HWY_INLINE DoubleDouble quotient(const DoubleDouble& top) const {
    return quotient_of(top, bottom, inverse);
  }
  HWY_INLINE V bound(V top_size, V value) const {
    return error_of_quotient(D(), top_size, bottom_size, inverse, value);
  }
  /// t.high is certainly the nearest float64.
  HWY_INLINE hn::Mask<D> certain() const { return hn::And(t.certain(error), ordinary); }
};

/// What t and everything behind it is made of, for several rays and the triangles that they meet.
template <class Tag>
struct IntersectionOf : PlaneOf<Tag>, MeetingOf<Tag> {
  /// Of the lanes that the columns begin with.
  HWY_INLINE explicit IntersectionOf(const MeetingColumns& columns)
      : PlaneOf<Tag>(columns), MeetingOf<Tag>(*this, columns.direction) {}
};

using PlanesAtOnce = PlaneOf<hn::CappedTag<double, 8>>;
using MeetingsAtOnce = MeetingOf<hn::CappedTag<double, 8>>;
using Intersection = IntersectionOf<hn::CappedTag<double, 8>>;

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
