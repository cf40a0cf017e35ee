// ExactSlabs: comparisons of two t, and roundings of one, without error and for a vector of pairs
// (docs/explanation/exactness-boxes.md, "Axis-aligned planes: batches").

#if defined(SIGHTLINE_TRACE_EXACT_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_EXACT_SLABS_INL_H_
#undef SIGHTLINE_TRACE_EXACT_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_EXACT_SLABS_INL_H_
#endif

#include <cstddef>
#include <limits>

#include "core/geometry/box_bounds.h"
#include "core/trace/kernel/double_double-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Exact arithmetic on lanes, for comparisons that the filter leaves open. Rarely called and not
/// inlined, so that the common case has its numbers in registers.
struct ExactSlabs {
  using D = hn::CappedTag<double, 8>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  using Sum = DoubleDoubleOf<D>;

  /// The sign of ta - tb as 1, 0 or -1, where ta = (a_plane - a_origin) / a_direction and tb is
  /// such a quotient; NaN if unknown.
  static HWY_NOINLINE V compare(V a_plane, V a_origin, V a_direction, V b_plane, V b_origin,
                                V b_direction) {
    const Sum a = numerator(a_plane, a_origin, a_direction),
              b = numerator(b_plane, b_origin, b_direction);
    const V a_rate = hn::Abs(a_direction), b_rate = hn::Abs(b_direction);
    const Sum left = Sum::two_product(a.high, b_rate), right = Sum::two_product(b.high, a_rate);
    M known = hn::And(is_exact_product(a.high, b_rate, left.high),
                      is_exact_product(b.high, a_rate, right.high));
    const V zero = hn::Zero(D());
    if (hn::AllTrue(D(), hn::And(hn::Eq(a.low, zero), hn::Eq(b.low, zero)))) {
      return sign(left, right, known);
    }
    // 100 bits decide unless the two t are equal, or nearly so.
    const V gap = hn::Sub(left.high, right.high);
    const V rest = hn::Add(hn::Sub(left.low, right.low),
                           hn::Sub(hn::Mul(a.low, b_rate), hn::Mul(b.low, a_rate)));
    const V difference = hn::Add(gap, rest);
    const V size = hn::Add(hn::Abs(left.high), hn::Abs(right.high));
    const V slack = hn::Add(hn::Mul(size, hn::Set(D(), box_bounds::kProductsSlack)),
                            hn::Mul(hn::Abs(gap), hn::Set(D(), box_bounds::kGapSlack)));
    const M certain = hn::And(hn::Gt(hn::Abs(difference), slack),
                              hn::And(hn::Gt(size, hn::Set(D(), box_bounds::kProductLeast)),
                                      hn::Lt(size, hn::Set(D(), box_bounds::kProductMost))));
    if (hn::AllTrue(D(), certain)) return sign({difference, zero}, {zero, zero}, known);
    const Sum left_rest = Sum::two_product(a.low, b_rate),
              right_rest = Sum::two_product(b.low, a_rate);
    known = hn::And(known, hn::And(is_exact_product(a.low, b_rate, left_rest.high),
                                   is_exact_product(b.low, a_rate, right_rest.high)));
    const Sum high = Sum::two_difference(left.high, right.high),
              low = Sum::two_difference(left.low, right.low),
              rest_high = Sum::two_difference(left_rest.high, right_rest.high),
              rest_low = Sum::two_difference(left_rest.low, right_rest.low);
    // Of nearly equal t most differences are float64 numbers.
    const M short_ones = hn::And(hn::And(hn::Eq(high.low, zero), hn::Eq(low.low, zero)),
                                 hn::And(hn::Eq(rest_high.low, zero), hn::Eq(rest_low.low, zero)));
    V sum;
    if (hn::AllTrue(D(), short_ones)) {
      const V terms[4] = {rest_low.high, low.high, rest_high.high, high.high};
      sum = last_part(terms);
    } else {
      const V terms[8] = {rest_low.low,  rest_low.high,  low.low,  low.high,
                          rest_high.low, rest_high.high, high.low, high.high};
      sum = last_part(terms);
    }
    return sign({sum, zero}, {zero, zero}, known);
  }
  /// The sign of ta - limit as 1, 0 or -1; NaN if unknown.
  static HWY_NOINLINE V compare(V plane, V origin, V direction, V limit) {
    const Sum a = numerator(plane, origin, direction);
    const Sum right = Sum::two_product(limit, hn::Abs(direction));
    return sign(a, right, is_exact_product(limit, hn::Abs(direction), right.high));
  }
  /// t = (plane - origin) / direction rounded once; NaN if the rounding is not certain. `t` is the
  /// float64 value of the filter.
  static HWY_INLINE V rounded(V t, V plane, V origin, V direction) {
    const V zero = hn::Zero(D());
    const Sum n = Sum::two_difference(plane, origin);
    const M is_short = hn::Eq(n.low, zero);
    const V first = hn::Add(t, zero);  // never -0
    if (hn::AllTrue(D(), is_short)) return first;
#if HWY_NATIVE_FMA
    const V rest = hn::NegMulAdd(t, direction, n.high);
#else
    const Sum product = Sum::two_product(t, direction);
    const V rest = hn::Sub(hn::Sub(n.high, product.high), product.low);
#endif
    const V correction = hn::Div(hn::Add(rest, n.low), direction);
    const V slack = hn::Add(hn::Mul(hn::Abs(correction), hn::Set(D(), box_bounds::kRefineSlack)),
                            hn::Set(D(), box_bounds::kRefineFloor));
    const V refined = hn::Add(t, correction);
    const V lost = hn::Add(hn::Sub(t, refined), correction);
    const M certain = hn::And(hn::Eq(hn::Add(refined, hn::Sub(lost, slack)), refined),
                              hn::Eq(hn::Add(refined, hn::Add(lost, slack)), refined));
    const V size = hn::Abs(t), top = hn::Abs(n.high), bottom = hn::Abs(direction);
    const M moderate = hn::And(hn::Gt(hn::Min(size, hn::Min(top, bottom)), hn::Set(D(), 0x1p-900)),
                               hn::Lt(hn::Max(size, hn::Max(top, bottom)), hn::Set(D(), 0x1p900)));
    const V unknown = hn::Set(D(), std::numeric_limits<double>::quiet_NaN());
    return hn::IfThenElse(is_short, first,
                          hn::IfThenElse(hn::And(certain, moderate), refined, unknown));
  }

 private:
  /// The numerator of t, plane - origin, with its sign turned if the direction is negative: the
  /// denominator is then |direction|.
  static HWY_INLINE Sum numerator(V plane, V origin, V direction) {
    const Sum n = Sum::two_difference(plane, origin);
    const V turn = hn::And(direction, hn::Set(D(), -0.0));
    return {hn::Xor(n.high, turn), hn::Xor(n.low, turn)};
  }
  static HWY_INLINE V sign(const Sum& a, const Sum& b, M known) {
    const V one = hn::Set(D(), 1), zero = hn::Zero(D());
    const M equal = hn::Eq(a.high, b.high);
    const M greater = hn::Or(hn::Gt(a.high, b.high), hn::And(equal, hn::Gt(a.low, b.low)));
    const M less = hn::Or(hn::Lt(a.high, b.high), hn::And(equal, hn::Lt(a.low, b.low)));
    const V result = hn::IfThenElse(greater, one, hn::IfThenElse(less, hn::Neg(one), zero));
    return hn::IfThenElse(known, result, hn::Set(D(), std::numeric_limits<double>::quiet_NaN()));
  }
  /// Lanes in which two_product is exact on every instruction set.
  static HWY_INLINE M is_exact_product(V a, V b, V product) {
    const V most = hn::Set(D(), box_bounds::kProductMost), zero = hn::Zero(D());
    const V size = hn::Abs(product);
    const M moderate =
        hn::And(hn::Ge(size, hn::Set(D(), box_bounds::kProductLeast)), hn::Le(size, most));
    const M finite = hn::And(hn::Le(hn::Abs(a), most), hn::Le(hn::Abs(b), most));
    return hn::And(finite, hn::Or(moderate, hn::Or(hn::Eq(a, zero), hn::Eq(b, zero))));
  }
  /// Returns a number that has the sign of the exact sum of eight terms. One term after the other
  /// is added to an expansion, a sum of parts that do not overlap. Its last nonzero part outweighs
  /// all parts before it [Shewchuk1997].
  template <std::size_t kTerms>
  static HWY_INLINE V last_part(const V (&terms)[kTerms]) {
    V parts[kTerms];
    V last = hn::Zero(D());
    SIGHTLINE_UNROLL
    for (std::size_t count = 0; count < kTerms; ++count) {
      V rest = terms[count];
      SIGHTLINE_UNROLL
      for (std::size_t i = 0; i < count; ++i) {
        const Sum sum = Sum::two_sum(rest, parts[i]);
        rest = sum.high;
        parts[i] = sum.low;
      }
      parts[count] = rest;
    }
    SIGHTLINE_UNROLL
    for (std::size_t i = 0; i < kTerms; ++i) {
      last = hn::IfThenElse(hn::Ne(parts[i], hn::Zero(D())), parts[i], last);
    }
    return last;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/run/boxes_test.cpp
