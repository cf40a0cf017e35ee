// VectorSlabs: the slab test for a vector of rays and axis-aligned boxes. It applies the rules of
// core/geometry/ray_box_decide.h to all lanes at once. ray_box must answer the pairs that remain
// open.
//
// Every comparison of two t begins with the float64 filter of core/geometry/ray_box.h. ExactSlabs
// decides the lanes that it leaves open.

#if defined(SIGHTLINE_TRACE_VECTOR_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_VECTOR_SLABS_INL_H_
#undef SIGHTLINE_TRACE_VECTOR_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_VECTOR_SLABS_INL_H_
#endif

#include <cstdint>

#include "core/geometry/box_bounds.h"
#include "core/geometry/ray_box.h"
#include "core/geometry/rounding.h"
#include "core/trace/ray_boxes/exact_slabs-inl.h"
#include "core/trace/ray_boxes/pair_columns.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Answers a vector of pairs. Members are single vectors and masks, because g++ 12 copies structs
/// and arrays of vectors through memory.
class VectorSlabs {
  using D = ExactSlabs::D;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;

 public:
  static constexpr std::size_t kLanes = hn::MaxLanes(D());
  /// Beyond half of it, no t of a ray that is parallel to a slab is decided.
  static constexpr double kWide = 0x1p1000;

  /// Answers the pairs from `first` on, a multiple of kLanes, as many as a vector has lanes. Sets
  /// the element `first` and those after it of each column of `answers`: if not kAll, only t and of
  /// the code only the outcome. Returns the lanes that are decided; in other lanes the results are
  /// arbitrary, and ray_box must answer.
  template <bool kAll>
  static HWY_INLINE M decide(const PairColumns& pairs, std::size_t first, PairAnswers& answers) {
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
    M is_parallel = none, beside = none, beside_second = none, beside_third = none;
    auto along = hn::Zero(du);
    const auto slab = [&](int k, M& near_on, M& far_on, M& near_shared, M& far_shared) HWY_ATTR
        __attribute__((always_inline)) {
      V lower = hn::Load(d, pairs.lower[k] + first);
      V upper = hn::Load(d, pairs.upper[k] + first);
      V origin = hn::Load(d, pairs.origin[k] + first);
      V direction = hn::Load(d, pairs.direction[k] + first);
      inside = hn::And(inside, hn::And(hn::Lt(lower, origin), hn::Lt(origin, upper)));
      const M in_slab = hn::And(hn::Le(lower, origin), hn::Le(origin, upper));
      within = hn::And(within, in_slab);
      if (const M parallel = hn::Eq(direction, zero); !hn::AllFalse(d, parallel)) {
        const M now = hn::AndNot(hn::Or(beside, in_slab), parallel);
        if (k == 1) beside_second = now;
        if (k == 2) beside_third = now;
        beside = hn::Or(beside, now);
        is_parallel = hn::Or(is_parallel, parallel);
        if constexpr (kAll) {
          const auto on = [&](V plane, int bit) HWY_ATTR __attribute__((always_inline)) {
            along = hn::Or(along, hn::IfThenElseZero(
                                      hn::RebindMask(du, hn::And(parallel, hn::Eq(plane, origin))),
                                      hn::Set(du, 1ull << (pc::kAlong + 2 * k + bit))));
          };
          on(lower, 0);
          on(upper, 1);
        }
        // A slab so wide that it does not matter, another width for each axis.
        const V wide = hn::Set(d, kWide * (k + 1));
        lower = hn::IfThenElse(parallel, hn::Neg(wide), lower);
        upper = hn::IfThenElse(parallel, wide, upper);
        origin = hn::IfThenZeroElse(parallel, origin);
        direction = hn::IfThenElse(parallel, hn::Set(d, 1), direction);
      }
      // Infinite sides that the ray is not parallel to are left to ray_box.
      decided = hn::And(
          decided, hn::And(hn::Lt(hn::Abs(lower), infinite), hn::Lt(hn::Abs(upper), infinite)));
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
    const V furthest = hn::Max(hn::Abs(enter), hn::Abs(exit));
    decided =
        hn::And(decided, hn::Or(hn::Not(is_parallel), hn::Lt(furthest, hn::Set(d, kWide / 2))));
    M apart, crosses, greater, less;
    order(enter, enter_plane, enter_origin, enter_direction, exit, exit_plane, exit_origin,
          exit_direction, decided, decided, apart, crosses);
    apart = hn::AndNot(beside, apart);
    const M line = hn::AndNot(hn::Or(apart, beside), decided);
    note(beside, static_cast<std::uint64_t>(RayBoxOutcome::kBeside));
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
      hn::Store(hn::IfThenElseZero(line, t_enter), d, answers.t_enter + first);
      hn::Store(hn::IfThenElseZero(line, t_exit), d, answers.t_exit + first);
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
    hn::Store(hn::IfThenElseZero(moves, t), d, answers.t + first);

    if constexpr (kAll) {
      note(inside, 1ull << pc::kInside);
      note(on_surface, 1ull << pc::kOnSurface);
      note(at_exit, 1ull << pc::kLeaving);
      // Of a ray beside the box the first slab, twice.
      const auto axis = [&](M entered_or_left, M beside_this) HWY_ATTR
          __attribute__((always_inline)) {
        return hn::Or(hn::AndNot(beside, entered_or_left), beside_this);
      };
      note(axis(enter_second, beside_second), 1ull << pc::kEnterAxis);
      note(axis(enter_third, beside_third), 2ull << pc::kEnterAxis);
      note(axis(exit_second, beside_second), 1ull << pc::kExitAxis);
      note(axis(exit_third, beside_third), 2ull << pc::kExitAxis);
      const M shows = hn::Or(at_origin, hn::Or(at_enter, at_exit));
      code = hn::Or(code, hn::IfThenElseZero(hn::RebindMask(du, shows), along));
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
    hn::Store(code, du, answers.code + first);
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
