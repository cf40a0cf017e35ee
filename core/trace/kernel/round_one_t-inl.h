// Rounds the t of a single hit, with the three axes in the lanes of a vector. It computes the sums
// of IntersectionOf (double_double-inl.h) with a short latency for a single ray.

#if defined(SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#undef SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#else
#define SIGHTLINE_TRACE_ROUND_ONE_T_INL_H_
#endif

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
/// Computes t of the ray o + t d and the triangle that it meets; corners are [corner][axis] in
/// world space.
HWY_INLINE RoundedT round_one(const double (&o)[3], const double (&d)[3],
                              const double (&corner)[3][3]) {
  const Axes dd;
  using Axial = DoubleDoubleOf<Axes>;
  using V = hn::Vec<Axes>;
  const auto xyz = [](const double(&v)[3]) { return axes_of(v[0], v[1], v[2]); };
  const auto zxy = [](const double(&v)[3]) { return axes_of(v[2], v[0], v[1]); };
  HWY_ALIGN static constexpr std::int64_t kNext[4] = {1, 2, 0, 0};
  const auto next = [&](V v) { return hn::TableLookupLanes(v, hn::SetTableIndices(dd, kNext)); };

  const V v0 = xyz(corner[0]);
  const Axial e1 = Axial::two_difference(xyz(corner[1]), v0);
  const Axial e2 = Axial::two_difference(xyz(corner[2]), v0);
  const V e1_next = next(e1.high), e2_next = next(e2.high);
  const bool short_edges = hn::AllTrue(dd, hn::Eq(hn::Or(e1.low, e2.low), hn::Zero(dd)));
  // From here on the axes are in the order z, x, y, in which the cross products come.
  const Axial n = HWY_LIKELY(short_edges)
                      ? Axial::two_product(e1.high, e2_next) - Axial::two_product(e1_next, e2.high)
                      : e1 * Axial{e2_next, next(e2.low)} - Axial{e1_next, next(e1.low)} * e2;
  const V size = hn::Add(hn::Abs(hn::Mul(e1.high, e2_next)), hn::Abs(hn::Mul(e1_next, e2.high)));
  const Axial a = Axial::two_difference(zxy(corner[0]), zxy(o));
  const V direction = zxy(d);
  const Axial top_terms = a * n, bottom_terms = direction * n;

  // Numerator and denominator in the lanes of one vector.
  const hn::CappedTag<double, 2> d2;
  using Pair = DoubleDoubleOf<hn::CappedTag<double, 2>>;
  const auto first = [&](V top, V bottom) {
    return hn::InterleaveLower(d2, hn::LowerHalf(top), hn::LowerHalf(bottom));
  };
  const auto second = [&](V top, V bottom) {
    return hn::InterleaveUpper(d2, hn::LowerHalf(top), hn::LowerHalf(bottom));
  };
  const auto third = [&](V top, V bottom) {
    return hn::InterleaveLower(d2, hn::UpperHalf(d2, top), hn::UpperHalf(d2, bottom));
  };
  const auto both = [&](const auto& pick) {
    return Pair{pick(top_terms.high, bottom_terms.high), pick(top_terms.low, bottom_terms.low)};
  };
  const Pair sums = both(first) + both(second) + both(third);
  const V top_part = hn::Mul(hn::Abs(a.high), size),
          bottom_part = hn::Mul(hn::Abs(direction), size);
  const auto sizes = hn::Add(hn::Add(first(top_part, bottom_part), second(top_part, bottom_part)),
                             third(top_part, bottom_part));
  const V largest = hn::MaxOfLanes(dd, hn::Max(size, hn::Max(hn::Abs(a.high), hn::Abs(direction))));

  const hn::CappedTag<double, 1> d1;
  const auto lower = [&](auto pair) { return hn::Set(d1, hn::GetLane(pair)); };
  const auto upper = [&](auto pair) { return hn::Set(d1, hn::ExtractLane(pair, 1)); };
  using One = DoubleDoubleOf<hn::CappedTag<double, 1>>;
  const One top{lower(sums.high), lower(sums.low)}, bottom{upper(sums.high), upper(sums.low)};
  const auto inverse = hn::Div(hn::Set(d1, 1.0), bottom.high);
  const One t = quotient_of(top, bottom, inverse);
  const auto error = error_of_quotient(d1, lower(sizes), upper(sizes), inverse, t.high);
  const auto ordinary =
      is_ordinary(d1, lower(sizes), upper(sizes), hn::Set(d1, hn::GetLane(largest)), t.high);
  return {hn::GetLane(t.high), hn::AllTrue(d1, hn::And(t.certain(error), ordinary))};
}
#else
/// Computes t of the ray o + t d and the triangle that it meets; corners are [corner][axis] in
/// world space.
HWY_INLINE RoundedT round_one(const double (&o)[3], const double (&d)[3],
                              const double (&corner)[3][3]) {
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
