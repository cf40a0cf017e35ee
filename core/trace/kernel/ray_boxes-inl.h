// VectorSlabs: the slab test for a vector of rays and axis-aligned boxes. It applies the rules of
// core/geometry/ray_box_decide.h to all lanes at once. ray_box must answer the pairs that remain
// open.
//
// Every comparison of two t begins with the float64 filter of core/geometry/ray_box.h. If that
// leaves lanes open, products and sums without error decide them
// (docs/explanation/exactness-boxes.md, "Axis-aligned planes: batches").

#if defined(SIGHTLINE_TRACE_RAY_BOXES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_RAY_BOXES_INL_H_
#undef SIGHTLINE_TRACE_RAY_BOXES_INL_H_
#else
#define SIGHTLINE_TRACE_RAY_BOXES_INL_H_
#endif

#include <array>
#include <bit>
#include <limits>

#include "core/geometry/box_bounds.h"
#include "core/geometry/ray_box.h"
#include "core/geometry/rounding.h"
#include "core/trace/kernel/double_double-inl.h"

#ifndef SIGHTLINE_TRACE_PAIR_CODE_ONCE
#define SIGHTLINE_TRACE_PAIR_CODE_ONCE
/// The code of an answer of VectorSlabs: the fields of RayBoxAnswer in one word, and the list of
/// faces that a code stands for.
namespace sightline::pair_code {

constexpr std::uint64_t kOutcome = 7;         ///< mask of the RayBoxOutcome
constexpr int kEnterAxis = 3, kExitAxis = 5;  ///< shifts of two bits: axis entered last, left first
constexpr std::uint64_t kInside = 1 << 7, kOnSurface = 1 << 8;
/// Shift of a bit: list the faces first through which the ray leaves. The bits from here on
/// determine the faces.
constexpr int kLeaving = 9;
constexpr int kNearFaces = 10, kFarFaces = 13;  ///< shifts of three bits, one per axis: faces at t
constexpr int kLowerFirst = 16;  ///< shift of three bits: the ray passes the lower plane first

/// RayBoxAnswer::faces for each value of the bits of a code from kLeaving on: 13 KiB. A loop over
/// the axes of each answer takes a third of the time of a pair.
inline constexpr std::array<BoxFaces, 1024> kFaces = [] {
  std::array<BoxFaces, 1024> lists{};
  for (std::uint64_t i = 0; i < lists.size(); ++i) {
    const std::uint64_t code = i << kLeaving;
    const bool leaving = (code >> kLeaving & 1) != 0;
    const std::uint64_t lower_first = code >> kLowerFirst & 7;
    for (const bool far : {leaving, !leaving}) {
      const std::uint64_t upper = far ? lower_first : ~lower_first;
      for (std::uint64_t axes = code >> (far ? kFarFaces : kNearFaces) & 7; axes != 0;
           axes &= axes - 1) {
        const int k = std::countr_zero(axes);
        lists[i].add({static_cast<std::uint8_t>(k), (upper >> k & 1) != 0});
      }
    }
  }
  return lists;
}();

}  // namespace sightline::pair_code
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Rays and boxes as columns: pair i is ray i and box i. kPairs fill the vectors of every
/// instruction set.
struct PairColumns {
  static constexpr std::size_t kPairs = 64;

  HWY_ALIGN double origin[3][kPairs], direction[3][kPairs], tmin[kPairs], tmax[kPairs];
  HWY_ALIGN double lower[3][kPairs], upper[3][kPairs];
};

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
    const Sum left_rest = Sum::two_product(a.low, b_rate),
              right_rest = Sum::two_product(b.low, a_rate);
    known = hn::And(known, hn::And(is_exact_product(a.low, b_rate, left_rest.high),
                                   is_exact_product(b.low, a_rate, right_rest.high)));
    const V terms[8] = {left_rest.low,  hn::Neg(right_rest.low),  left.low,  hn::Neg(right.low),
                        left_rest.high, hn::Neg(right_rest.high), left.high, hn::Neg(right.high)};
    return sign({last_part(terms), zero}, {zero, zero}, known);
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
    const M moderate =
        hn::And(is_moderate(t), hn::And(is_moderate(n.high), is_moderate(direction)));
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
  static HWY_INLINE M is_moderate(V x) {
    const V size = hn::Abs(x);
    return hn::And(hn::Gt(size, hn::Set(D(), 0x1p-900)), hn::Lt(size, hn::Set(D(), 0x1p900)));
  }
  /// Returns a number that has the sign of the exact sum of eight terms. One term after the other
  /// is added to an expansion, a sum of parts that do not overlap. Its last nonzero part outweighs
  /// all parts before it [Shewchuk1997].
  static HWY_INLINE V last_part(const V (&terms)[8]) {
    V parts[8];
    V last = hn::Zero(D());
    SIGHTLINE_UNROLL
    for (int count = 0; count < 8; ++count) {
      V rest = terms[count];
      SIGHTLINE_UNROLL
      for (int i = 0; i < count; ++i) {
        const Sum sum = Sum::two_sum(rest, parts[i]);
        rest = sum.high;
        parts[i] = sum.low;
      }
      parts[count] = rest;
    }
    SIGHTLINE_UNROLL
    for (int i = 0; i < 8; ++i) {
      last = hn::IfThenElse(hn::Ne(parts[i], hn::Zero(D())), parts[i], last);
    }
    return last;
  }
};

/// Answers a vector of pairs. Members are single vectors and masks, because g++ 12 copies structs
/// and arrays of vectors through memory.
class VectorSlabs {
  using D = ExactSlabs::D;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;

 public:
  static constexpr std::size_t kLanes = hn::MaxLanes(D());

  /// Answers the pairs from `first` on, a multiple of kLanes, as many as a vector has lanes. Stores
  /// t, t_enter and t_exit (if kAll), and `code` (if not kAll, only its outcome), at index `first`
  /// of the arrays. Returns the lanes that are decided; in other lanes the results are arbitrary,
  /// and ray_box must answer.
  template <bool kAll>
  static HWY_INLINE M decide(const PairColumns& pairs, std::size_t first, double* t_to,
                             double* enter_to, double* exit_to, std::uint64_t* code_to) {
    namespace pc = pair_code;
    const D d;
    const DU du;
    const V zero = hn::Zero(d), infinite = hn::Set(d, kInfD);
    const M all = hn::Eq(zero, zero), none = hn::Not(all);
    M decided = all;
    auto code = hn::Zero(du);
    const auto note = [&](M lanes, std::uint64_t value) HWY_ATTR __attribute__((always_inline)) {
      code = hn::Or(code, hn::IfThenElseZero(hn::RebindMask(du, lanes), hn::Set(du, value)));
    };

    // Finds the last entry and the first exit; of equal ones that of the smaller axis.
    M inside = all, within = all, enter_second = none, enter_third = none, exit_second = none,
      exit_third = none, near_shared0 = all, near_shared1 = none, near_shared2 = none,
      far_shared0 = all, far_shared1 = none, far_shared2 = none;
    M near_on0 = none, near_on1 = none, near_on2 = none, far_on0 = none, far_on1 = none,
      far_on2 = none;
    V enter = zero, enter_plane = zero, enter_origin = zero, enter_direction = zero, exit = zero,
      exit_plane = zero, exit_origin = zero, exit_direction = zero;
    const auto slab = [&](int k, M& near_on, M& far_on, M& near_shared, M& far_shared) HWY_ATTR
        __attribute__((always_inline)) {
      const V lower = hn::Load(d, pairs.lower[k] + first);
      const V upper = hn::Load(d, pairs.upper[k] + first);
      const V origin = hn::Load(d, pairs.origin[k] + first);
      const V direction = hn::Load(d, pairs.direction[k] + first);
      inside = hn::And(inside, hn::And(hn::Lt(lower, origin), hn::Lt(origin, upper)));
      within = hn::And(within, hn::And(hn::Le(lower, origin), hn::Le(origin, upper)));
      // Parallel rays and infinite sides are left to ray_box.
      decided = hn::And(
          decided, hn::And(hn::Ne(direction, zero), hn::And(hn::Lt(hn::Abs(lower), infinite),
                                                            hn::Lt(hn::Abs(upper), infinite))));
      const M falls = hn::Lt(direction, zero);
      const V near_plane = hn::IfThenElse(falls, upper, lower);
      const V far_plane = hn::IfThenElse(falls, lower, upper);
      const V near = hn::Div(hn::Sub(near_plane, origin), direction);
      const V far = hn::Div(hn::Sub(far_plane, origin), direction);
      if constexpr (kAll) {
        note(hn::Not(falls), 1ull << (pc::kLowerFirst + k));
        near_on = hn::Eq(near_plane, origin);
        far_on = hn::Eq(far_plane, origin);
      }
      if (k == 0) {
        enter = near;
        exit = far;
        enter_plane = near_plane;
        exit_plane = far_plane;
        enter_origin = exit_origin = origin;
        enter_direction = exit_direction = direction;
        return;
      }
      const auto take = [&](M wins, V t, V plane, V & best, V & best_plane, V & best_origin,
                            V & best_direction) HWY_ATTR __attribute__((always_inline)) {
        best = hn::IfThenElse(wins, t, best);
        best_plane = hn::IfThenElse(wins, plane, best_plane);
        best_origin = hn::IfThenElse(wins, origin, best_origin);
        best_direction = hn::IfThenElse(wins, direction, best_direction);
      };
      M greater, less;
      order(near, near_plane, origin, direction, enter, enter_plane, enter_origin, enter_direction,
            decided, decided, greater, less);
      take(greater, near, near_plane, enter, enter_plane, enter_origin, enter_direction);
      if constexpr (kAll) {
        near_shared0 = hn::AndNot(greater, near_shared0);
        if (k == 2) near_shared1 = hn::AndNot(greater, near_shared1);
        near_shared = hn::Not(less);
        enter_second = k == 1 ? greater : hn::AndNot(greater, enter_second);
        if (k == 2) enter_third = greater;
      }
      order(far, far_plane, origin, direction, exit, exit_plane, exit_origin, exit_direction,
            decided, decided, greater, less);
      take(less, far, far_plane, exit, exit_plane, exit_origin, exit_direction);
      if constexpr (kAll) {
        far_shared0 = hn::AndNot(less, far_shared0);
        if (k == 2) far_shared1 = hn::AndNot(less, far_shared1);
        far_shared = hn::Not(greater);
        exit_second = k == 1 ? less : hn::AndNot(less, exit_second);
        if (k == 2) exit_third = less;
      }
    };
    slab(0, near_on0, far_on0, near_shared0, far_shared0);
    slab(1, near_on1, far_on1, near_shared1, far_shared1);
    slab(2, near_on2, far_on2, near_shared2, far_shared2);
    const M on_surface = hn::AndNot(inside, within);

    // The outcome.
    const V tmin = hn::Load(d, pairs.tmin + first), tmax = hn::Load(d, pairs.tmax + first);
    const auto order_enter = [&](V limit, M care, M & greater, M & less) HWY_ATTR
        __attribute__((always_inline)) {
      order(enter, enter_plane, enter_origin, enter_direction, limit, care, decided, greater, less);
    };
    const auto order_exit = [&](V limit, M care, M & greater, M & less) HWY_ATTR
        __attribute__((always_inline)) {
      order(exit, exit_plane, exit_origin, exit_direction, limit, care, decided, greater, less);
    };
    M apart, crosses, greater, less;
    order(enter, enter_plane, enter_origin, enter_direction, exit, exit_plane, exit_origin,
          exit_direction, decided, decided, apart, crosses);
    const M line = hn::AndNot(apart, decided);
    order_exit(tmin, line, greater, less);
    const M behind = hn::And(less, line);
    const M ahead = hn::AndNot(behind, line);
    order_enter(tmax, ahead, greater, less);
    const M beyond = hn::And(greater, ahead);
    const M hit = hn::AndNot(beyond, ahead);
    note(apart, static_cast<std::uint64_t>(RayBoxOutcome::kApart));
    note(behind, static_cast<std::uint64_t>(RayBoxOutcome::kBehind));
    note(beyond, static_cast<std::uint64_t>(RayBoxOutcome::kBeyond));

    // Chooses t, as Decision::choose_t does.
    const M at_origin =
        hn::And(hn::And(hit, on_surface), hn::And(hn::Le(tmin, zero), hn::Ge(tmax, zero)));
    const M moves = hn::AndNot(at_origin, hit);
    const M comes = hn::AndNot(inside, moves);
    order_enter(tmin, comes, greater, less);
    M at_enter = hn::AndNot(less, comes);
    M at_exit = none;
    if (const M others = hn::AndNot(at_enter, moves); !hn::AllFalse(d, others)) {
      order_exit(tmax, others, greater, less);
      at_exit = hn::AndNot(greater, others);
      const M stays = hn::And(hn::AndNot(at_exit, others), inside);
      order_enter(tmin, stays, greater, less);
      at_enter = hn::Or(at_enter, hn::AndNot(less, stays));
    }
    const auto rounded = [&](M care, V t, V plane, V origin, V direction) HWY_ATTR
        __attribute__((always_inline)) {
      const V once = ExactSlabs::rounded(t, plane, origin, direction);
      decided = hn::AndNot(hn::And(care, hn::IsNaN(once)), decided);
      return once;
    };
    V t;
    if constexpr (kAll) {
      const V t_enter = rounded(line, enter, enter_plane, enter_origin, enter_direction);
      const V t_exit = rounded(line, exit, exit_plane, exit_origin, exit_direction);
      hn::Store(hn::IfThenElseZero(line, t_enter), d, enter_to + first);
      hn::Store(hn::IfThenElseZero(line, t_exit), d, exit_to + first);
      t = hn::IfThenElse(at_enter, t_enter, hn::IfThenElse(at_exit, t_exit, infinite));
    } else {
      const M met = hn::Or(at_enter, at_exit);
      t = hn::IfThenElse(met,
                         rounded(met, hn::IfThenElse(at_exit, exit, enter),
                                 hn::IfThenElse(at_exit, exit_plane, enter_plane),
                                 hn::IfThenElse(at_exit, exit_origin, enter_origin),
                                 hn::IfThenElse(at_exit, exit_direction, enter_direction)),
                         infinite);
    }
    hn::Store(hn::IfThenElseZero(moves, t), d, t_to + first);

    if constexpr (kAll) {
      note(inside, pc::kInside);
      note(on_surface, pc::kOnSurface);
      note(at_exit, 1ull << pc::kLeaving);
      note(enter_second, 1ull << pc::kEnterAxis);
      note(enter_third, 2ull << pc::kEnterAxis);
      note(exit_second, 1ull << pc::kExitAxis);
      note(exit_third, 2ull << pc::kExitAxis);
      // Far planes contain the point where the line enters, and near planes the point where it
      // leaves, only if both points have one t.
      const M touches = hn::Not(hn::Or(apart, crosses));
      const M near = hn::Or(at_enter, hn::And(at_exit, touches));
      const M far = hn::Or(at_exit, hn::And(at_enter, touches));
      const auto faces = [&](M shared, M lanes, M on_origin, int bit) HWY_ATTR
          __attribute__((always_inline)) {
        note(hn::Or(hn::And(lanes, shared), hn::And(at_origin, on_origin)), 1ull << bit);
      };
      faces(near_shared0, near, near_on0, pc::kNearFaces);
      faces(near_shared1, near, near_on1, pc::kNearFaces + 1);
      faces(near_shared2, near, near_on2, pc::kNearFaces + 2);
      faces(far_shared0, far, far_on0, pc::kFarFaces);
      faces(far_shared1, far, far_on1, pc::kFarFaces + 1);
      faces(far_shared2, far, far_on2, pc::kFarFaces + 2);
    }
    hn::Store(code, du, code_to + first);
    return decided;
  }

 private:
  /// Compares t a with t b in the lanes of `care`; results of other lanes are arbitrary. Lanes that
  /// remain open are removed from `decided`.
  static HWY_INLINE void order(V a, V a_plane, V a_origin, V a_direction, V b, V b_plane,
                               V b_origin, V b_direction, M care, M& decided, M& greater, M& less) {
    const M open = filter(a, b, hn::Add(hn::Abs(a), hn::Abs(b)), care, greater, less);
    if (hn::AllFalse(D(), open)) return;
    take_sign(ExactSlabs::compare(a_plane, a_origin, a_direction, b_plane, b_origin, b_direction),
              open, decided, greater, less);
  }
  static HWY_INLINE void order(V a, V plane, V origin, V direction, V limit, M care, M& decided,
                               M& greater, M& less) {
    const M open = filter(a, limit, hn::Abs(a), care, greater, less);
    if (hn::AllFalse(D(), open)) return;
    take_sign(ExactSlabs::compare(plane, origin, direction, limit), open, decided, greater, less);
  }
  static HWY_INLINE M filter(V a, V b, V size, M care, M& greater, M& less) {
    // A product and a sum: a fused operation with a subnormal number is slow on Intel
    // (docs/decisions/0026).
    const V slack = hn::Add(hn::Mul(size, hn::Set(D(), box_bounds::kCrossingSlack)),
                            hn::Set(D(), box_bounds::kCrossingFloor));
    const V gap = hn::Sub(a, b);
    greater = hn::Gt(gap, slack);
    less = hn::Lt(gap, hn::Neg(slack));
    return hn::AndNot(hn::Or(greater, less), care);
  }
  static HWY_INLINE void take_sign(V sign, M open, M& decided, M& greater, M& less) {
    const V zero = hn::Zero(D());
    greater = hn::Or(greater, hn::And(open, hn::Gt(sign, zero)));
    less = hn::Or(less, hn::And(open, hn::Lt(sign, zero)));
    decided = hn::AndNot(hn::And(open, hn::IsNaN(sign)), decided);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/run/boxes_test.cpp
