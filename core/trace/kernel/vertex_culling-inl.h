// Vertex culling: excludes triangles of a leaf for all rays of a packet at once.

#if defined(SIGHTLINE_TRACE_VERTEX_CULLING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_VERTEX_CULLING_INL_H_
#undef SIGHTLINE_TRACE_VERTEX_CULLING_INL_H_
#else
#define SIGHTLINE_TRACE_VERTEX_CULLING_INL_H_
#endif

#include "core/trace/bounds.h"
#include "core/trace/kernel/filter-inl.h"
#include "core/trace/kernel/prepare-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Vertex culling [Reshetov2007]: tests a triangle for a whole packet by the packet's corner rays.
/// Call set() for a packet, then see() and triangles_that_may_be_met() for the triangles of a block
/// that suits() accepts.
///
/// The rays start at one point and have the same axes kx, ky, kz, so their shears lie in a
/// rectangle. The sheared corners and edge functions of a triangle are linear in a ray's shears. So
/// the corners of the rectangle bound them for all rays (docs/explanation/exactness.md, "Vertex
/// culling").
template <std::size_t kRays>
class VertexCulling {
 public:
  /// Sets the rays: the first `lanes` of the columns, which fill whole vectors. `reach` is at least
  /// the reach of every ray. Returns false, and the object must not be used, if the rays do not
  /// start at one point. Precondition: all rays have equal axes kx, ky, kz.
  bool set(const PreparedColumns<kRays>& rays, std::size_t lanes, double reach) {
    const D d;
    auto same = hn::FirstN(d, hn::Lanes(d));
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      origin_[k] = rays.origin[k][0];
      for (std::size_t i = 0; i < lanes; i += hn::Lanes(d))
        same = hn::And(same, hn::Eq(hn::Load(d, rays.origin[k] + i), hn::Set(d, origin_[k])));
    }
    if (!hn::AllTrue(d, same)) return false;
    set_range(rays.shear_x, lanes, shear_x_);
    set_range(rays.shear_y, lanes, shear_y_);
    const double unit = kU * reach;
    coordinate_error_ = bounds::kSlack * unit + bounds::kSignFloor;
    edge_error_ = bounds::kVertexCulling * unit * reach + bounds::kSignFloor;
    return true;
  }

  /// True if the error of edge functions is small enough to decide triangles whose largest edge
  /// component is `edge`.
  bool suits(double edge) const { return edge_error_ * 0x1p12 <= edge * edge; }

  /// The triangles relative to the common origin of the rays.
  HWY_INLINE LaneEdges<FilterLanes> see(const LaneCorners<FilterLanes>& corners) const {
    const FilterLanes d;
    hn::Vec<FilterLanes> x[3], y[3];
    LaneEdges<FilterLanes> seen;
    seen.error = edge_error_;
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      x[c] = hn::Sub(corners.x[c], hn::Set(d, origin_[0]));
      y[c] = hn::Sub(corners.y[c], hn::Set(d, origin_[1]));
      seen.z[c] = hn::Sub(corners.z[c], hn::Set(d, origin_[2]));
    }
    // The edge functions of the filter, expanded: for the edge from corner j to i, w = nz + sx nx +
    // sy ny, where n is normal to the plane through the edge and the origin.
    const auto& z = seen.z;
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = (c + 2) % 3, j = (c + 1) % 3;
      seen.normal_x[c] = hn::MulSub(y[i], z[j], hn::Mul(z[i], y[j]));
      seen.normal_y[c] = hn::MulSub(z[i], x[j], hn::Mul(x[i], z[j]));
      seen.normal_z[c] = hn::MulSub(x[i], y[j], hn::Mul(y[i], x[j]));
    }
    return seen;
  }

  /// Bit i is set if some ray may meet triangle i; if it is not set, certainly no ray does. `seen`
  /// is the result of see(corners).
  HWY_INLINE std::uint32_t triangles_that_may_be_met(const LaneCorners<FilterLanes>& corners,
                                                     const LaneEdges<FilterLanes>& seen) const {
    const FilterLanes d;
    using V = hn::Vec<FilterLanes>;
    V x[3], y[3];
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      x[c] = hn::Sub(corners.x[c], hn::Set(d, origin_[0]));
      y[c] = hn::Sub(corners.y[c], hn::Set(d, origin_[1]));
    }
    auto out = hn::Or(beside(x, seen.z, shear_x_, coordinate_error_),
                      beside(y, seen.z, shear_y_, coordinate_error_));
    V highest = hn::Zero(d), lowest = hn::Zero(d);
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      const Range by_x = products(seen.normal_x[c], shear_x_);
      const Range by_y = products(seen.normal_y[c], shear_y_);
      const V low = hn::Add(seen.normal_z[c], hn::Add(by_x.low, by_y.low));
      const V high = hn::Add(seen.normal_z[c], hn::Add(by_x.high, by_y.high));
      highest = c == 0 ? low : hn::Max(highest, low);
      lowest = c == 0 ? high : hn::Min(lowest, high);
    }
    const V error = hn::Set(d, edge_error_);
    out = hn::Or(out, hn::And(hn::Gt(highest, error), hn::Lt(lowest, hn::Neg(error))));
    return mask_bits(d, hn::Not(out));
  }

 private:
  using D = hn::CappedTag<double, kGroupRays>;
  struct Range {
    hn::Vec<FilterLanes> low, high;
  };

  static void set_range(const double* values, std::size_t count, double (&range)[2]) {
    range[0] = least_of(D(), values, count);
    range[1] = most_of(D(), values, count);
  }
  static HWY_INLINE Range products(hn::Vec<FilterLanes> factor, const double (&range)[2]) {
    const FilterLanes d;
    const auto a = hn::Mul(factor, hn::Set(d, range[0]));
    const auto b = hn::Mul(factor, hn::Set(d, range[1]));
    return {hn::Min(a, b), hn::Max(a, b)};
  }
  /// True in lanes whose corners are all on one side of all rays.
  static HWY_INLINE hn::Mask<FilterLanes> beside(const hn::Vec<FilterLanes> (&across)[3],
                                                 const hn::Vec<FilterLanes> (&along)[3],
                                                 const double (&shear)[2], double error) {
    const FilterLanes d;
    auto low = hn::Zero(d), high = hn::Zero(d);
    SIGHTLINE_UNROLL
    for (std::size_t c = 0; c < 3; ++c) {
      const Range sheared = products(along[c], shear);
      const auto least = hn::Sub(across[c], sheared.high), most = hn::Sub(across[c], sheared.low);
      low = c == 0 ? least : hn::Min(low, least);
      high = c == 0 ? most : hn::Max(high, most);
    }
    return hn::Or(hn::Gt(low, hn::Set(d, error)), hn::Lt(high, hn::Set(d, -error)));
  }

  double origin_[3];                ///< on the axes kx, ky, kz
  double shear_x_[2], shear_y_[2];  ///< least and largest shear of all rays
  double coordinate_error_, edge_error_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
