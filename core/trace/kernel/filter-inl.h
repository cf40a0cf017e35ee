// The float64 filter for a ray and the four triangles of a leaf block: decides which triangles are
// certainly met or missed. filter_block is for one ray and all lanes of a block, filter_lanes for
// vectors of rays or triangles. tau and the forms of a ray are those of ray_setup.h.

#if defined(SIGHTLINE_TRACE_FILTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_FILTER_INL_H_
#undef SIGHTLINE_TRACE_FILTER_INL_H_
#else
#define SIGHTLINE_TRACE_FILTER_INL_H_
#endif

#include <cmath>

#include "core/bvh/scene_tree.h"
#include "core/geometry/rounding.h"
#include "core/trace/bounds.h"
#include "core/trace/kernel/simd-inl.h"
#include "core/trace/ray_setup.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The layouts of scenes, for which traversals are compiled separately (with_layout chooses one).
enum class Layout {
  /// one entry, whose placements change no coordinate: corners of blocks are world corners
  kAsItIs,
  kPlaced,  ///< one entry, whose placements have matrices: corners are mapped to world space
  kMany     ///< several entries below a top tree; corners are mapped to world space
};

/// How triangles that are missed are handled. kLatency: the caller waits for the verdict, so a
/// branch skips the division for them. kThroughput: many independent tests follow one another, and
/// a mispredicted branch costs more than the division.
enum class Pace { kLatency, kThroughput };

/// The result of the filter for one ray and the lanes of a block. Bit i of `accept`: triangle i is
/// certainly met within the limits. Bit i of `examine`: it may be met, and the exact predicate must
/// decide. Bit i of `back`, where that of `accept` is set: the ray meets its back.
struct LeafBits {
  std::uint32_t accept = 0;
  std::uint32_t examine = 0;
  std::uint32_t back = 0;

  /// Clears the bits of lanes that repeat lane 0 of the block. Returns false if no bit is left.
  HWY_INLINE bool keep_lanes_of(const LeafBlock& block) {
    const std::uint32_t lanes = (1u << block.lane_count()) - 1u;
    accept &= lanes;
    examine &= lanes;
    return (accept | examine) != 0;
  }
};

/// LeafBits with intervals: [low[i], high[i]] contains tau of triangle i if its bit of `accept` is
/// set, or if that of `examine` is set and the ray meets it. Other elements have no meaning.
struct LeafVerdict : LeafBits {
  HWY_ALIGN double low[kLanes];
  HWY_ALIGN double high[kLanes];
};

/// A number of a single ray, for all lanes. It is broadcast where it is used, so lanes that are
/// decided early do not wait for the rest. Refers to the number, which must outlive it.
template <class D>
struct Broadcast {
  const double& number;
  HWY_INLINE operator hn::Vec<D>() const { return hn::Set(D(), number); }  // NOLINT(*-explicit-*)
};

/// The values of a ray that the filter uses (FilterRay): one ray in all lanes, or a ray in each
/// lane. Number is a vector, or Broadcast.
template <class D, class Number = hn::Vec<D>>
struct LaneRays {
  Number origin[3];  ///< on the axes kx, ky, kz
  Number shear_x, shear_y, inverse_z;
  Number tau_min_low, tau_min_high, tau_max_low;
  Number bound;  ///< upper bound of the best tau so far
};

/// Corners in world space on the axes kx, ky, kz of the rays: one triangle in all lanes, or a
/// triangle in each lane.
template <class D>
struct LaneCorners {
  hn::Vec<D> x[3], y[3], z[3];
};

/// The result of the filter for each lane.
template <class D>
struct LaneVerdicts {
  hn::Mask<D> left;      ///< not certainly missed: the triangle may be met
  hn::Mask<D> certain;   ///< if left: certainly met, within the limits
  hn::Mask<D> back;      ///< if certain: the ray meets the triangle's back
  hn::Vec<D> low, high;  ///< interval that contains tau, if left
};

/// Decides lanes from their edge functions `w` and the depths `z` of the corners along the ray's
/// largest axis, if each w is off by at most `e`: Theorems 1 and 2 of
/// docs/explanation/exactness.md, "Triangles". `edge` is an upper bound of |component| of all edges
/// of the triangles in world space, `reach` of the reach of all rays. Returns false, without
/// verdicts, only if all lanes are certainly missed.
template <Pace kPace, class D, class Number, class V = hn::Vec<D>>
HWY_INLINE bool judge_lanes(D dd, const V (&w)[3], const V (&z)[3], V e, double edge,
                            const LaneRays<D, Number>& rays, double reach,
                            LaneVerdicts<D>& verdicts) {
  using namespace bounds;
  const double unit = kU * reach;
  const V least = hn::Min(w[0], hn::Min(w[1], w[2]));
  const V most = hn::Max(w[0], hn::Max(w[1], w[2]));
  const V minus_e = hn::Neg(e);
  const auto out = hn::And(hn::Lt(least, minus_e), hn::Gt(most, e));
  if (kPace == Pace::kLatency && hn::AllTrue(dd, out)) return false;

  // tau = z on the ray / direction z, as an interval; it holds for uncertain lanes too, if they
  // are met at all.
  const V inverse_z = rays.inverse_z;
  const V determinant = hn::Add(hn::Add(w[0], w[1]), w[2]);
  const V inverse = hn::Div(hn::Set(dd, 1.0), determinant);
  const V sum = hn::MulAdd(w[0], z[0], hn::MulAdd(w[1], z[1], hn::Mul(w[2], z[2])));
  const V tau = hn::Mul(hn::Mul(sum, inverse), inverse_z);
  const V width = hn::Mul(hn::MulAdd(hn::MulAdd(e, hn::Set(dd, kTauEdge * edge + kTauReach * unit),
                                                hn::Set(dd, kSignFloor)),
                                     hn::Abs(inverse), hn::Set(dd, kTau * unit)),
                          hn::Mul(hn::Abs(inverse_z), hn::Set(dd, 1 + 0x1p-40)));
  verdicts.low = hn::Sub(tau, width);
  verdicts.high = hn::Add(tau, width);

  // Certainly outside the limits or behind the best: out. Certainly inside the limits: as the
  // signs say. NaN is neither.
  const V tau_min_low = rays.tau_min_low, tau_min_high = rays.tau_min_high;
  const V tau_max_low = rays.tau_max_low, bound = rays.bound;
  const auto outside = hn::Or(hn::Lt(verdicts.high, tau_min_low), hn::Gt(verdicts.low, bound));
  const auto inside =
      hn::And(hn::Ge(verdicts.low, tau_min_high), hn::Le(verdicts.high, tau_max_low));
  verdicts.left = hn::Not(hn::Or(out, outside));
  verdicts.certain = hn::And(hn::Or(hn::Gt(least, e), hn::Lt(most, minus_e)), inside);
  // direction . normal = -direction z * determinant, and edge functions that are certain have the
  // sign of their sum.
  verdicts.back = hn::Xor(hn::Lt(determinant, hn::Zero(dd)), hn::Lt(inverse_z, hn::Zero(dd)));
  return true;
}

/// The filter for triangles given by their corners: sheared edge functions [Woop2013] with the
/// error bound of docs/explanation/exactness.md, "Triangles". Other arguments and the result are
/// those of judge_lanes.
template <Pace kPace, class D, class Number>
HWY_INLINE bool filter_lanes(D dd, const LaneCorners<D>& corners, double edge,
                             const LaneRays<D, Number>& rays, double reach,
                             LaneVerdicts<D>& verdicts) {
  using V = hn::Vec<D>;
  using namespace bounds;
  const double unit = kU * reach;
  const V origin[3] = {rays.origin[0], rays.origin[1], rays.origin[2]};
  const V shear_x = rays.shear_x, shear_y = rays.shear_y;
  // The corners relative to the origin, sheared so that the ray is the z axis.
  V x[3], y[3], z[3];
  SIGHTLINE_UNROLL
  for (std::size_t c = 0; c < 3; ++c) {
    z[c] = hn::Sub(corners.z[c], origin[2]);
    x[c] = hn::NegMulAdd(shear_x, z[c], hn::Sub(corners.x[c], origin[0]));
    y[c] = hn::NegMulAdd(shear_y, z[c], hn::Sub(corners.y[c], origin[1]));
  }
  const V w[3] = {hn::MulSub(x[2], y[1], hn::Mul(y[2], x[1])),
                  hn::MulSub(x[0], y[2], hn::Mul(y[0], x[2])),
                  hn::MulSub(x[1], y[0], hn::Mul(y[1], x[0]))};
  // E bounds the error of each w; m bounds every sheared coordinate through corner 0 and the
  // edges.
  const V m = hn::Add(hn::Max(hn::Abs(x[0]), hn::Abs(y[0])), hn::Set(dd, 2 * edge + kSlack * unit));
  const V e = hn::MulAdd(hn::Set(dd, kSign * unit), m, hn::Set(dd, kSignFloor));
  return judge_lanes<kPace>(dd, w, z, e, edge, rays, reach, verdicts);
}

/// Triangles relative to an origin that several rays share: one triangle in all lanes, or a
/// triangle in each lane. Edge function c of a ray from there is normal_z[c] + shear_x normal_x[c]
/// + shear_y normal_y[c]. VertexCulling::see makes them.
template <class D>
struct LaneEdges {
  hn::Vec<D> normal_x[3], normal_y[3], normal_z[3];
  hn::Vec<D> z[3];  ///< depths of the corners, relative to the origin
  double error;     ///< bounds the error of every edge function
};

/// The filter for rays from the origin of `seen`: docs/explanation/exactness.md, "Vertex culling".
/// Other arguments and the result are those of judge_lanes.
template <Pace kPace, class D, class Number>
HWY_INLINE bool filter_lanes(D dd, const LaneEdges<D>& seen, double edge,
                             const LaneRays<D, Number>& rays, double reach,
                             LaneVerdicts<D>& verdicts) {
  hn::Vec<D> w[3];
  const hn::Vec<D> shear_x = rays.shear_x, shear_y = rays.shear_y;
  SIGHTLINE_UNROLL
  for (std::size_t c = 0; c < 3; ++c) {
    w[c] = hn::MulAdd(shear_x, seen.normal_x[c],
                      hn::MulAdd(shear_y, seen.normal_y[c], seen.normal_z[c]));
  }
  return judge_lanes<kPace>(dd, w, seen.z, hn::Set(dd, seen.error), edge, rays, reach, verdicts);
}

/// Lanes of float64 numbers for the triangles of a block: four, or two at a time.
using FilterLanes = hn::CappedTag<double, kLanes>;

/// Loads the corners of the triangles of a block from a lane on, in mesh space: as many as D, a tag
/// of at most four float32 or float64, has lanes.
template <class D>
class CornerLoader {
 public:
  using V = hn::Vec<D>;

  HWY_INLINE CornerLoader(const LeafBlock& block, std::size_t lane) : block_(block), lane_(lane) {
    if (block.has_numbers()) numbers_ = block.vertex_numbers() >> 3 * lane;
  }

  /// Sets corner[c] to corner c of the triangles, on an axis of the mesh.
  HWY_INLINE void load(std::size_t axis, V (&corner)[3]) const {
    const float* column = block_.vertices(axis);
    if (HWY_LIKELY(block_.has_numbers())) return look_up(column, corner);
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c)
      corner[c] = converted(hn::Load(Floats(), column + lane_ + c * kLanes));
  }

 private:
  using Floats = hn::Rebind<float, D>;

  static HWY_INLINE V converted(hn::Vec<Floats> v) {
    if constexpr (sizeof(hn::TFromD<D>) == sizeof(float))
      return v;
    else
      return hn::PromoteTo(D(), v);
  }

#if HWY_MAX_BYTES >= 32
  using Eight = hn::CappedTag<float, 2 * kLanes>;

  HWY_INLINE void look_up(const float* vertex, V (&corner)[3]) const {
    const auto vertices = hn::LoadU(Eight(), vertex);
    // Corners 0 and 1 in one permutation.
    const auto two = hn::TableLookupLanes(vertices, numbers_from(0));
    const auto third = hn::TableLookupLanes(vertices, numbers_from(2));
    corner[0] = converted(hn::LowerHalf(Floats(), two));
    corner[1] = converted(hn::UpperHalf(Floats(), two));
    corner[2] = converted(hn::LowerHalf(Floats(), third));
  }
  HWY_INLINE auto numbers_from(std::size_t corner) const {
    const hn::RebindToUnsigned<Eight> du;
    // Each number of three bits moves to the top of its lane, then down.
    HWY_ALIGN static constexpr std::uint32_t kUp[] = {29, 26, 23, 20, 17, 14, 11, 8};
    const auto all = hn::Set(du, static_cast<std::uint32_t>(numbers_ >> 3 * kLanes * corner));
    return hn::IndicesFromVec(Eight(), hn::ShiftRight<29>(hn::Shl(all, hn::Load(du, kUp))));
  }
#else
  HWY_INLINE void look_up(const float* vertex, V (&corner)[3]) const {
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      const auto at = [&](std::size_t lane) {
        const float number = vertex[numbers_ >> 3 * (kLanes * c + lane) & 7u];
        return static_cast<hn::TFromD<D>>(number);
      };
#if HWY_TARGET == HWY_SCALAR
      corner[c] = hn::Set(D(), at(0));
#else
      if constexpr (hn::MaxLanes(D()) == 2) {
        corner[c] = hn::InterleaveLower(D(), hn::Set(D(), at(0)), hn::Set(D(), at(1)));
      } else {
        HWY_ALIGN const hn::TFromD<D> lanes[] = {at(0), at(1), at(2), at(3)};
        corner[c] = hn::Load(D(), lanes);
      }
#endif
    }
  }
#endif

  const LeafBlock& block_;
  std::size_t lane_;
  std::uint64_t numbers_ = 0;  ///< from the first lane on
};

/// Loads the corners of the triangles of a block from lane `i` on, as many as a vector has lanes,
/// on the axes of `ray`. If kPlaced, maps them to world space by the formula of Affine::apply.
/// `placement` is that of the block.
template <bool kPlaced>
HWY_INLINE LaneCorners<FilterLanes> load_corners(const LeafBlock& block, std::size_t i,
                                                 const FilterRay& ray, const Placement& placement) {
  const FilterLanes dd;
  const CornerLoader<FilterLanes> loader(block, i);
  LaneCorners<FilterLanes> corners;
  if (!kPlaced || placement.diagonal) {
    loader.load(ray.kx, corners.x);
    loader.load(ray.ky, corners.y);
    loader.load(ray.kz, corners.z);
    if constexpr (kPlaced) {
      // What is left of the sums below: adding zeros changes no more than the sign of a zero.
      const auto map = [&](std::uint32_t k, hn::Vec<FilterLanes>(&corner)[3]) {
        const double* m = placement.world_from_mesh.m[k];
        SIGHTLINE_UNROLL
        for (auto& v : corner) v = hn::Add(hn::Mul(hn::Set(dd, m[k]), v), hn::Set(dd, m[3]));
      };
      map(ray.kx, corners.x);
      map(ray.ky, corners.y);
      map(ray.kz, corners.z);
    }
    return corners;
  }
  hn::Vec<FilterLanes> mesh[3][3];
  loader.load(0, mesh[0]);
  loader.load(1, mesh[1]);
  loader.load(2, mesh[2]);
  // Separate products and sums, left to right.
  const auto map = [&](std::uint32_t k, hn::Vec<FilterLanes>(&corner)[3]) {
    const double* m = placement.world_from_mesh.m[k];
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      corner[c] = hn::Add(hn::Add(hn::Add(hn::Mul(hn::Set(dd, m[0]), mesh[0][c]),
                                          hn::Mul(hn::Set(dd, m[1]), mesh[1][c])),
                                  hn::Mul(hn::Set(dd, m[2]), mesh[2][c])),
                          hn::Set(dd, m[3]));
    }
  };
  map(ray.kx, corners.x);
  map(ray.ky, corners.y);
  map(ray.kz, corners.z);
  return corners;
}

/// An upper bound of |component| of all edges of a block, in world space. `placement` is that of
/// the block.
template <bool kPlaced>
HWY_INLINE double largest_edge(const LeafBlock& block, const Placement& placement) {
  const auto edge = static_cast<double>(block.edge_max());
  if constexpr (!kPlaced) return edge;
  return (edge * placement.edge_scale + placement.edge_pad) * (1 + 0x1p-50);
}

/// Filters triangles (LaneCorners or LaneEdges of the lanes from `i` on) for one ray. `edge` and
/// `reach` are those of judge_lanes. `bound` is the upper bound of the ray's best tau so far. Adds
/// bits to the verdict, and sets its elements from `i` on.
template <Pace kPace, class Triangles>
HWY_INLINE void filter_triangles(const Triangles& triangles, double edge, const FilterRay& ray,
                                 double reach, double bound, std::size_t i, LeafVerdict& verdict) {
  const FilterLanes dd;
  const LaneRays<FilterLanes, Broadcast<FilterLanes>> rays{
      {{ray.origin[0]}, {ray.origin[1]}, {ray.origin[2]}},
      {ray.shear_x},
      {ray.shear_y},
      {ray.inverse_z},
      {ray.tau_min_low},
      {ray.tau_min_high},
      {ray.tau_max_low},
      {bound}};
  LaneVerdicts<FilterLanes> found;
  if (!filter_lanes<kPace>(dd, triangles, edge, rays, reach, found)) return;
  hn::Store(found.low, dd, verdict.low + i);
  hn::Store(found.high, dd, verdict.high + i);
  const std::uint32_t left = mask_bits(dd, found.left);
  const std::uint32_t certain = mask_bits(dd, found.certain);
  verdict.accept |= (left & certain) << i;
  verdict.examine |= (left & ~certain) << i;
  verdict.back |= mask_bits(dd, found.back) << i;
}

/// Filters all lanes of a block for one ray, and sets the verdict. `placement` is that of the
/// block, `bound` the upper bound of the ray's best tau so far.
template <bool kPlaced, Pace kPace>
HWY_INLINE void filter_block(const LeafBlock& block, const FilterRay& ray,
                             const Placement& placement, double bound, LeafVerdict& verdict) {
  const double edge = largest_edge<kPlaced>(block, placement);
  verdict.accept = verdict.examine = verdict.back = 0;
  for (std::size_t i = 0; i < kLanes; i += hn::Lanes(FilterLanes())) {
    filter_triangles<kPace>(load_corners<kPlaced>(block, i, ray, placement), edge, ray, ray.reach,
                            bound, i, verdict);
  }
  verdict.keep_lanes_of(block);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
