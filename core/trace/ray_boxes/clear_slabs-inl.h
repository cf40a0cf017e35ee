// ClearSlabs: the slab test for a vector of pairs in which the float64 filter decides every
// comparison, with fewer operations than VectorSlabs
// (docs/explanation/exactness-boxes.md, "Axis-aligned planes: clear pairs").

#if defined(SIGHTLINE_TRACE_CLEAR_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_CLEAR_SLABS_INL_H_
#undef SIGHTLINE_TRACE_CLEAR_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_CLEAR_SLABS_INL_H_
#endif

#include <cstdint>

#include "core/geometry/box_bounds.h"
#include "core/geometry/rounding.h"
#include "core/trace/ray_boxes/exact_slabs-inl.h"
#include "core/trace/ray_boxes/pair_columns.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Answers a vector of pairs in two steps, decide() and round(). A processor overlaps the steps of
/// several vectors only if a loop over each step is short.
class ClearSlabs {
  using D = ExactSlabs::D;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  using U = hn::Vec<DU>;

 public:
  /// Decides the pairs from `first` on, a multiple of the number of lanes, as many as a vector has
  /// lanes. True if all of them are clear; only then the results are set, at index `first` of each
  /// column: `code`, and in `enters` the crossing whose t is the answer. kAll: in `enters` and
  /// `exits` where the line enters and leaves the box, if it does. !kAll: of `code` only the
  /// outcome; `exits` is not written.
  template <bool kAll>
  static HWY_INLINE bool decide(const PairColumns& pairs, std::size_t first, Crossings& enters,
                                Crossings& exits, std::uint64_t* code_to) {
    const D d;
    const DU du;
    const V zero = hn::Zero(d);
    V near[3], far[3];
    SIGHTLINE_UNROLL
    for (int k = 0; k < 3; ++k) {
      const V origin = hn::Load(d, pairs.origin[k] + first);
      const V direction = hn::Load(d, pairs.direction[k] + first);
      near[k] = hn::Div(hn::Sub(near_plane(pairs, k, first), origin), direction);
      far[k] = hn::Div(hn::Sub(far_plane(pairs, k, first), origin), direction);
    }
    const V later = hn::Max(near[0], near[1]), sooner = hn::Min(far[0], far[1]);
    const Last entry{hn::Gt(near[1], near[0]), hn::Gt(near[2], later)},
        leave{hn::Lt(far[1], far[0]), hn::Lt(far[2], sooner)};
    const V enter = hn::Max(later, near[2]), exit = hn::Min(sooner, far[2]);
    const V tmin = hn::Load(d, pairs.tmin + first), tmax = hn::Load(d, pairs.tmax + first);
    const V slack = hn::Add(
        hn::Mul(hn::Add(hn::Abs(enter), hn::Abs(exit)), hn::Set(d, box_bounds::kCrossingSlack)),
        hn::Set(d, box_bounds::kCrossingFloor));
    const V least_gap =
        hn::Min(hn::Min(gap(enter, exit), hn::Min(gap(exit, tmin), gap(enter, tmax))),
                hn::Min(gap(enter, tmin), gap(exit, tmax)));
    // A t of zero may have lost its sign by underflow.
    M clear =
        hn::And(hn::Gt(least_gap, slack), hn::Gt(hn::Min(hn::Abs(enter), hn::Abs(exit)), zero));
    // The plane of the entry is certain if no other near plane is crossed shortly before it.
    const V wider = hn::Mul(slack, hn::Set(d, box_bounds::kSecondSlack));
    const V second = hn::Max(hn::Min(near[0], near[1]), hn::Min(later, near[2]));
    clear = hn::And(clear, hn::Gt(hn::Sub(enter, second), wider));
    // Infinite or not a number: a parallel ray, an infinite side, or an overflow.
    const V sum = hn::Add(hn::Add(hn::Add(near[0], near[1]), hn::Add(near[2], far[0])),
                          hn::Add(far[1], far[2]));
    clear = hn::And(clear, hn::Lt(hn::Abs(sum), hn::Set(d, kInfD)));
    if (!hn::AllTrue(d, clear)) return false;

    // The outcome, and the choice of t as in Decision::choose_t.
    const M apart = hn::Gt(enter, exit), behind = hn::Lt(exit, tmin), beyond = hn::Gt(enter, tmax);
    const M hit = hn::Not(hn::Or(apart, hn::Or(behind, beyond)));
    const M inside = hn::And(hn::Lt(enter, zero), hn::Gt(exit, zero));
    const M comes = hn::Gt(enter, tmin);
    const M at_exit = hn::And(hn::And(hit, hn::Lt(exit, tmax)), hn::Or(inside, hn::Not(comes)));
    const M at_enter = hn::AndNot(at_exit, hn::And(hit, comes));
    const M meets = hn::Or(at_enter, at_exit);
    // [tmin, tmax] lies in the interior: rare.
    if (!hn::AllTrue(d, hn::Or(hn::Not(hit), meets))) return false;
    U code = when(beyond, static_cast<std::uint64_t>(RayBoxOutcome::kBeyond));
    code = hn::IfThenElse(hn::RebindMask(du, behind), outcome(RayBoxOutcome::kBehind), code);
    code = hn::IfThenElse(hn::RebindMask(du, apart), outcome(RayBoxOutcome::kApart), code);

    V t = enter;
    V plane = choose(entry, near_plane(pairs, 0, first), near_plane(pairs, 1, first),
                     near_plane(pairs, 2, first));
    V origin = choose(entry, pairs.origin, first);
    V direction = choose(entry, pairs.direction, first);
    if constexpr (kAll) store(hn::Not(apart), t, plane, origin, direction, first, enters);
    if (kAll || !hn::AllFalse(d, at_exit)) {
      const V next = hn::Min(hn::Max(far[0], far[1]), hn::Max(sooner, far[2]));
      if (!hn::AllTrue(d, hn::Gt(hn::Sub(next, exit), wider))) return false;
      const V exit_plane = choose(leave, far_plane(pairs, 0, first), far_plane(pairs, 1, first),
                                  far_plane(pairs, 2, first));
      const V exit_origin = choose(leave, pairs.origin, first);
      const V exit_direction = choose(leave, pairs.direction, first);
      if constexpr (kAll) {
        store(hn::Not(apart), exit, exit_plane, exit_origin, exit_direction, first, exits);
      } else {
        t = hn::IfThenElse(at_exit, exit, t);
        plane = hn::IfThenElse(at_exit, exit_plane, plane);
        origin = hn::IfThenElse(at_exit, exit_origin, origin);
        direction = hn::IfThenElse(at_exit, exit_direction, direction);
      }
    }
    if constexpr (kAll) {
      namespace pc = pair_code;
      code = hn::Or(code, hn::Or(axis_and_face(entry, at_enter, pc::kEnterAxis, pc::kNearFaces),
                                 axis_and_face(leave, at_exit, pc::kExitAxis, pc::kFarFaces)));
      code = hn::Or(code,
                    hn::Or(when(inside, 1ull << pc::kInside), when(at_exit, 1ull << pc::kLeaving)));
      SIGHTLINE_UNROLL
      for (int k = 0; k < 3; ++k) {
        const M rises = hn::Gt(hn::Load(d, pairs.direction[k] + first), zero);
        code = hn::Or(code, when(rises, 1ull << (pc::kLowerFirst + k)));
      }
    } else {
      store(meets, t, plane, origin, direction, first, enters);
    }
    hn::Store(code, du, code_to + first);
    return true;
  }

  /// Rounds the t of the crossings from `first` on, and stores them, or 0 where none is asked for.
  /// False if the rounding of one is not certain.
  static HWY_INLINE bool round(const Crossings& at, std::size_t first, double* to) {
    const D d;
    const V t =
        ExactSlabs::rounded(hn::Load(d, at.t + first), hn::Load(d, at.plane + first),
                            hn::Load(d, at.origin + first), hn::Load(d, at.direction + first));
    hn::Store(t, d, to + first);
    return hn::AllFalse(d, hn::IsNaN(t));
  }

 private:
  /// Which axis wins: z, else y, else x.
  struct Last {
    M y, z;
  };

  static HWY_INLINE V gap(V a, V b) { return hn::Abs(hn::Sub(a, b)); }
  static HWY_INLINE U outcome(RayBoxOutcome one) {
    return hn::Set(DU(), static_cast<std::uint64_t>(one));
  }
  static HWY_INLINE U when(M lanes, std::uint64_t bits) {
    return hn::IfThenElseZero(hn::RebindMask(DU(), lanes), hn::Set(DU(), bits));
  }
  static HWY_INLINE V near_plane(const PairColumns& pairs, int k, std::size_t first) {
    return plane_of(pairs.lower[k], pairs.upper[k], pairs.direction[k], first);
  }
  static HWY_INLINE V far_plane(const PairColumns& pairs, int k, std::size_t first) {
    return plane_of(pairs.upper[k], pairs.lower[k], pairs.direction[k], first);
  }
  static HWY_INLINE V plane_of(const double* rising, const double* falling, const double* direction,
                               std::size_t first) {
    const D d;
    return hn::IfNegativeThenElse(hn::Load(d, direction + first), hn::Load(d, falling + first),
                                  hn::Load(d, rising + first));
  }
  static HWY_INLINE V choose(const Last& axis, V x, V y, V z) {
    return hn::IfThenElse(axis.z, z, hn::IfThenElse(axis.y, y, x));
  }
  static HWY_INLINE V choose(const Last& axis, const double (&column)[3][kBlockPairs],
                             std::size_t first) {
    const D d;
    return choose(axis, hn::Load(d, column[0] + first), hn::Load(d, column[1] + first),
                  hn::Load(d, column[2] + first));
  }
  /// The bits of an axis, and of its face in `lanes`.
  static HWY_INLINE U axis_and_face(const Last& axis, M lanes, int axis_shift, int face_shift) {
    const DU du;
    const auto of = [&](std::uint64_t x, std::uint64_t y, std::uint64_t z, int shift) HWY_ATTR
        __attribute__((always_inline)) {
      return hn::IfThenElse(hn::RebindMask(du, axis.z), hn::Set(du, z << shift),
                            hn::IfThenElse(hn::RebindMask(du, axis.y), hn::Set(du, y << shift),
                                           hn::Set(du, x << shift)));
    };
    return hn::Or(of(0, 1, 2, axis_shift),
                  hn::IfThenElseZero(hn::RebindMask(du, lanes), of(1, 2, 4, face_shift)));
  }
  static HWY_INLINE void store(M lanes, V t, V plane, V origin, V direction, std::size_t first,
                               Crossings& to) {
    const D d;
    hn::Store(hn::IfThenElseZero(lanes, t), d, to.t + first);
    hn::Store(hn::IfThenElseZero(lanes, plane), d, to.plane + first);
    hn::Store(hn::IfThenElseZero(lanes, origin), d, to.origin + first);
    hn::Store(direction, d, to.direction + first);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/run/boxes_test.cpp
