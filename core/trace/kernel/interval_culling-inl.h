// Interval culling of a packet [Boulos2006] [Reshetov2005]. One interval for each axis bounds the
// origins and inverse directions of all rays of the packet. One slab test of these intervals
// rejects a box for all rays. Also tests a box for each ray alone. A limit of a ray is an upper
// bound of the tau that matters, in tree units (BoxRay::limit). A slot is the index of a child in
// its node.

#if defined(SIGHTLINE_TRACE_INTERVAL_CULLING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_INTERVAL_CULLING_INL_H_
#undef SIGHTLINE_TRACE_INTERVAL_CULLING_INL_H_
#else
#define SIGHTLINE_TRACE_INTERVAL_CULLING_INL_H_
#endif

#include "core/trace/kernel/prepare-inl.h"
#include "core/trace/kernel/slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The interval of up to kRays rays of one octant. Call set() for a packet, set_limit() when limits
/// shrink, then children() and rays_that_meet(). The interval enters a slab no later, and leaves it
/// no earlier, than any of the rays. Rounded differences and products are monotone, so it suffices
/// to use the extremes of the rays' origins and inverse directions (docs/explanation/exactness.md,
/// "Boxes").
template <std::size_t kRays>
class IntervalCulling {
 public:
  /// Sets the rays: the first `lanes` of the columns, all of the octant of lane 0. `lanes` fills
  /// whole vectors, and lanes without a ray must repeat a ray. `limit` is the largest limit of the
  /// rays. `one_origin`: all rays start at one point.
  void set(const PreparedColumns<kRays>& columns, std::size_t lanes, bool one_origin, float limit) {
    lanes_ = lanes;
    const bool negative[3] = {(columns.negative[0] & 1u) != 0, (columns.negative[1] & 1u) != 0,
                              (columns.negative[2] & 1u) != 0};
    BoxRay rows;
    rows.set_octant(negative[0], negative[1], negative[2]);
    octant_ = rows.octant;
    for (std::size_t k = 0; k < 3; ++k) {
      near_row_[k] = rows.near_row[k];
      far_row_[k] = BoxRay::kBothRows[k] ^ rows.near_row[k];
      if (one_origin) {
        near_origin_[k] = columns.near_origin[k][0];
        far_origin_[k] = columns.far_origin[k][0];
      } else {
        near_origin_[k] =
            negative[k] ? least(columns.near_origin[k]) : most(columns.near_origin[k]);
        far_origin_[k] = negative[k] ? most(columns.far_origin[k]) : least(columns.far_origin[k]);
      }
      near_inverse_[k][0] = least(columns.near_inverse[k]);
      near_inverse_[k][1] = most(columns.near_inverse[k]);
      // The larger |inverse| last: it may be infinite.
      far_inverse_[k][negative[k] ? 1 : 0] = least(columns.far_inverse[k]);
      far_inverse_[k][negative[k] ? 0 : 1] = most(columns.far_inverse[k]);
    }
    tau_min_ = least(columns.box_min);
    one_origin_ = one_origin;
    limit_ = limit;
  }
  /// Sets the largest limit of the rays.
  void set_limit(float limit) { limit_ = limit; }
  /// The largest limit that was set.
  float limit() const { return limit_; }

  /// Writes the slots of the children that the interval meets, the nearest last, and their entry
  /// distances. Returns their number; eight elements of both arrays may be overwritten.
  HWY_INLINE std::size_t children(const WideNode& node, std::uint32_t* HWY_RESTRICT slot_out,
                                  float* HWY_RESTRICT near_out) const {
    const BoxCrossings boxes = cross_boxes(node);
    ChildList list(node, boxes);
    list.sort(node, octant_);
    return list.store_slots(slot_out, near_out);
  }

  /// Returns the rays of `some` that meet the box of the child in `slot` before their limits; bit i
  /// is ray i. `columns` are those of set(); limits[i] is the limit of ray i. A ray with the limit
  /// -inf meets no box.
  HWY_INLINE LaneBits rays_that_meet(const WideNode& node, std::uint32_t slot,
                                     const PreparedColumns<kRays>& columns, const float* limits,
                                     LaneBits some) const {
    if (one_origin_) return rays_from_one_point_that_meet(node, slot, columns, limits, some);
    const D d;
    const float* planes = &node.lower[0][slot];
    LaneBits met = 0;
    for (std::size_t i = 0; i < lanes_; i += hn::Lanes(d)) {
      if ((some >> i & ((LaneBits{1} << hn::Lanes(d)) - 1)) == 0) continue;
      auto near = hn::Load(d, columns.box_min + i);
      auto far = hn::Load(d, limits + i);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        const auto before =
            hn::Sub(hn::Set(d, planes[near_row_[k]]), hn::Load(d, columns.near_origin[k] + i));
        const auto behind =
            hn::Sub(hn::Set(d, planes[far_row_[k]]), hn::Load(d, columns.far_origin[k] + i));
        near = max_unless_nan(d, hn::Mul(before, hn::Load(d, columns.near_inverse[k] + i)), near);
        far = min_unless_nan(d, hn::Mul(behind, hn::Load(d, columns.far_inverse[k] + i)), far);
      }
      met |= LaneBits{mask_bits(d, hn::Le(near, far))} << i;
    }
    return met;
  }

 private:
  using D = hn::CappedTag<float, kRays>;

  HWY_INLINE BoxCrossings cross_boxes(const WideNode& node) const {
    const BoxLanes df;
    const float* planes = &node.lower[0][0];
    BoxCrossings boxes;
    SIGHTLINE_UNROLL
    for (std::size_t v = 0; v < kBoxVectors; ++v) {
      auto near = hn::Set(df, tau_min_);
      auto far = hn::Set(df, limit_);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        const auto before = hn::Sub(hn::Load(df, planes + near_row_[k] + v * kBoxLanes),
                                    hn::Set(df, near_origin_[k]));
        const auto behind = hn::Sub(hn::Load(df, planes + far_row_[k] + v * kBoxLanes),
                                    hn::Set(df, far_origin_[k]));
        near = max_unless_nan(df,
                              hn::Min(hn::Mul(before, hn::Set(df, near_inverse_[k][0])),
                                      hn::Mul(before, hn::Set(df, near_inverse_[k][1]))),
                              near);
        // 0 * inf is NaN and says nothing.
        far = min_unless_nan(df,
                             nan_or_max(df, hn::Mul(behind, hn::Set(df, far_inverse_[k][0])),
                                        hn::Mul(behind, hn::Set(df, far_inverse_[k][1]))),
                             far);
      }
      boxes.near[v] = near;
      boxes.far[v] = far;
    }
    return boxes;
  }

  /// rays_that_meet for rays from one point, whose differences are computed once.
  HWY_INLINE LaneBits rays_from_one_point_that_meet(const WideNode& node, std::uint32_t slot,
                                                    const PreparedColumns<kRays>& columns,
                                                    const float* limits, LaneBits some) const {
    const D d;
    const float* planes = &node.lower[0][slot];
    hn::Vec<D> before[3], behind[3];
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      before[k] = hn::Set(d, planes[near_row_[k]] - near_origin_[k]);
      behind[k] = hn::Set(d, planes[far_row_[k]] - far_origin_[k]);
    }
    LaneBits met = 0;
    for (std::size_t i = 0; i < lanes_; i += hn::Lanes(d)) {
      if ((some >> i & ((LaneBits{1} << hn::Lanes(d)) - 1)) == 0) continue;
      auto near = hn::Load(d, columns.box_min + i);
      auto far = hn::Load(d, limits + i);
      SIGHTLINE_UNROLL
      for (std::size_t k = 0; k < 3; ++k) {
        near =
            max_unless_nan(d, hn::Mul(before[k], hn::Load(d, columns.near_inverse[k] + i)), near);
        far = min_unless_nan(d, hn::Mul(behind[k], hn::Load(d, columns.far_inverse[k] + i)), far);
      }
      met |= LaneBits{mask_bits(d, hn::Le(near, far))} << i;
    }
    return met;
  }

  float least(const float* values) const { return least_of(D(), values, lanes_); }
  float most(const float* values) const { return most_of(D(), values, lanes_); }

  std::uint32_t octant_ = 0;
  std::uint32_t near_row_[3], far_row_[3];  ///< as in BoxRay
  float near_origin_[3], far_origin_[3];
  float near_inverse_[3][2], far_inverse_[3][2];  ///< the extremes of all rays
  float tau_min_, limit_;
  bool one_origin_ = false;
  std::size_t lanes_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
