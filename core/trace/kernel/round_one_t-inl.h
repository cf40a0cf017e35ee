// Rounds the t of a single hit, with the three axes in the lanes of a vector. The sums have a
// shorter latency than those of IntersectionOf (double_double-inl.h), for a single ray.

#if defined(SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#undef SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#else
#define SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#endif

#include "core/bvh/leaf_block.h"
#include "core/geometry/affine.h"
#include "core/trace/kernel/double_double-inl.h"
#include "core/trace/kernel/prepare-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The t of a hit, and whether its rounding is proved.
struct RoundedT {
  double t;
  bool certain;  ///< t is certainly the float64 nearest to the exact t
};

#if HWY_MAX_BYTES >= 32
/// The corners of a triangle in world space.
class WorldCorners {
 public:
  /// Of a lane of a block; `matrix` maps to world space, and null changes nothing.
  HWY_INLINE WorldCorners(const LeafBlock& block, std::size_t lane, const Affine* matrix) {
    if (HWY_UNLIKELY(matrix != nullptr)) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3d corner = matrix->apply(block.corner(c, lane));
        corner_[c] = axes_of(corner.x, corner.y, corner.z);
      }
      return;
    }
    const hn::Rebind<float, Axes> df;
    const float* x = block.vertices(0);
    const std::size_t capacity = block.capacity();
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      const float* at = x + block.vertex(c, lane);
      const auto xy = hn::InterleaveLower(df, hn::Set(df, at[0]), hn::Set(df, at[capacity]));
      corner_[c] =
          hn::PromoteTo(Axes(), hn::ConcatLowerLower(df, hn::Set(df, at[2 * capacity]), xy));
    }
  }
  /// The axes of corner c, as those of axes_of.
  HWY_INLINE hn::Vec<Axes> operator[](std::size_t c) const { return corner_[c]; }

 private:
  hn::Vec<Axes> corner_[3];
};

/// Computes t of the ray o + t d and the triangle that it meets.
HWY_INLINE RoundedT round_one(const double (&o)[3], const double (&d)[3],
                              const WorldCorners& corner) {
  const Axes dd;
  using Axial = DoubleDoubleOf<Axes>;
  using V = hn::Vec<Axes>;
  const auto zxy = [](const double(&v)[3]) { return axes_of(v[2], v[0], v[1]); };
  HWY_ALIGN static constexpr std::int64_t kNext[4] = {1, 2, 0, 0}, kLast[4] = {2, 0, 1, 1};
  const auto next = [&](V v) { return hn::TableLookupLanes(v, hn::SetTableIndices(dd, kNext)); };
  const auto last = [&](V v) { return hn::TableLookupLanes(v, hn::SetTableIndices(dd, kLast)); };

  const V v0 = corner[0];
  const Axial e1 = Axial::two_difference(corner[1], v0);
  const Axial e2 = Axial::two_difference(corner[2], v0);
  const V e1_next = next(e1.high), e2_next = next(e2.high);
  const bool short_edges = hn::AllTrue(dd, hn::Eq(hn::Or(e1.low, e2.low), hn::Zero(dd)));
  // From here on the axes are in the order z, x, y, in which the cross products come.
  const auto cross = [&](const Axial& p, const Axial& q) HWY_ATTR {
    // Not normalised: the low part is at most 2 u size.
    const Axial s = Axial::two_difference(p.high, q.high);
    return Axial{s.high, hn::Add(s.low, hn::Sub(p.low, q.low))};
  };
  const Axial n =
      HWY_LIKELY(short_edges)
          ? cross(Axial::two_product(e1.high, e2_next), Axial::two_product(e1_next, e2.high))
          : cross(e1 * Axial{e2_next, next(e2.low)}, Axial{e1_next, next(e1.low)} * e2);
  const V size = hn::Add(hn::Abs(hn::Mul(e1.high, e2_next)), hn::Abs(hn::Mul(e1_next, e2.high)));
  const Axial a = Axial::two_difference(last(v0), zxy(o));
  const V direction = zxy(d);
  const Axial top_terms = Axial::two_product(a.high, n.high),
              bottom_terms = Axial::two_product(direction, n.high);
  const V top_lows = hn::MulAdd(a.low, n.high, hn::MulAdd(a.high, n.low, top_terms.low)),
          bottom_lows = hn::MulAdd(direction, n.low, bottom_terms.low);

  // Numerator and denominator in the lanes of one vector.
  const hn::CappedTag<double, 2> d2;
  using Pair = DoubleDoubleOf<hn::CappedTag<double, 2>>;
  const auto first = [&](V top, V bottom) HWY_ATTR {
    return hn::InterleaveLower(d2, hn::LowerHalf(top), hn::LowerHalf(bottom));
  };
  const auto second = [&](V top, V bottom) HWY_ATTR {
    return hn::InterleaveUpper(d2, hn::LowerHalf(top), hn::LowerHalf(bottom));
  };
  const auto third = [&](V top, V bottom) HWY_ATTR {
    return hn::InterleaveLower(d2, hn::UpperHalf(d2, top), hn::UpperHalf(d2, bottom));
  };
  const auto sum_of = [&](V top, V bottom) HWY_ATTR {
    return hn::Add(hn::Add(first(top, bottom), second(top, bottom)), third(top, bottom));
  };
  const Pair two = Pair::two_sum(first(top_terms.high, bottom_terms.high),
                                 second(top_terms.high, bottom_terms.high));
  const Pair three = Pair::two_sum(two.high, third(top_terms.high, bottom_terms.high));
  const Pair sums = Pair::fast_two_sum(
      three.high, hn::Add(hn::Add(sum_of(top_lows, bottom_lows), two.low), three.low));
  const V top_part = hn::Mul(hn::Abs(a.high), size),
          bottom_part = hn::Mul(hn::Abs(direction), size);
  const auto sizes = sum_of(top_part, bottom_part);
  const bool in_range =
      hn::AllTrue(dd, hn::Le(hn::Max(size, hn::Max(hn::Abs(a.high), hn::Abs(direction))),
                             hn::Set(dd, kLargestFactor)));

  const hn::CappedTag<double, 1> d1;
  const auto lower = [&](auto pair) { return hn::Set(d1, hn::GetLane(pair)); };
  const auto upper = [&](auto pair) { return hn::Set(d1, hn::ExtractLane(pair, 1)); };
  using One = DoubleDoubleOf<hn::CappedTag<double, 1>>;
  const One top{lower(sums.high), lower(sums.low)}, bottom{upper(sums.high), upper(sums.low)};
  const auto inverse = hn::Div(hn::Set(d1, 1.0), bottom.high);
  const One t = quotient_of(top, bottom, inverse);
  const auto error = error_of_quotient(d1, lower(sizes), upper(sizes), inverse, t.high);
  const auto ordinary = is_ordinary(d1, lower(sizes), upper(sizes), hn::Zero(d1), t.high);
  return {hn::GetLane(t.high), in_range && hn::AllTrue(d1, hn::And(t.certain(error), ordinary))};
}
#else
/// The corners of a triangle in world space, as [corner][axis].
class WorldCorners {
 public:
  /// Of a lane of a block; `matrix` maps to world space, and null changes nothing.
  HWY_INLINE WorldCorners(const LeafBlock& block, std::size_t lane, const Affine* matrix) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3f mesh = block.corner(c, lane);
      const Vec3d corner = matrix != nullptr ? matrix->apply(mesh) : Vec3d{mesh.x, mesh.y, mesh.z};
      for (int k = 0; k < 3; ++k) corner_[c][k] = corner[k];
    }
  }
  const double (&operator[](std::size_t c) const)[3] { return corner_[c]; }

 private:
  double corner_[3][3];
};

/// Computes t of the ray o + t d and the triangle that it meets.
HWY_INLINE RoundedT round_one(const double (&o)[3], const double (&d)[3],
                              const WorldCorners& corner) {
  const hn::CappedTag<double, 1> d1;
  MeetingColumns columns;
  for (std::size_t k = 0; k < 3; ++k) {
    columns.origin[k] = &o[k];
    columns.direction[k] = &d[k];
    for (std::size_t c = 0; c < 3; ++c) columns.corner[c][k] = &corner[c][k];
  }
  const IntersectionOf<hn::CappedTag<double, 1>> meeting(columns);
  return {hn::GetLane(meeting.t.high),
          hn::AllTrue(d1, hn::And(meeting.t.certain(meeting.error), meeting.ordinary))};
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
