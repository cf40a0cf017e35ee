// Ray against the eight boxes of a node, all at once [Wald2008].

#if defined(SIGHTLINE_TRACE_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SLABS_INL_H_
#undef SIGHTLINE_TRACE_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_SLABS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <bit>

#include "core/bvh/wide_tree.h"
#include "core/trace/kernel/child_list-inl.h"
#include "core/trace/kernel/simd-inl.h"
#include "core/trace/ray_setup.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// Starts fetching a node, or as much of a leaf.
HWY_INLINE void fetch_node(const std::byte* target) {
  SIGHTLINE_UNROLL
  for (std::size_t i = 0; i < sizeof(WideNode); i += 64) hwy::Prefetch(target + i);
}

/// Siblings that may wait, of one ray in flight or one packet.
constexpr std::size_t kWaiting = 248;

/// Where the ray enters and leaves the boxes of a node, from box `i` on: [Kay1986] slabs,
/// conservative as BoxRay says.
HWY_INLINE hn::Vec<BoxLanes> slab_near(const WideNode& node, const BoxRay& ray, std::size_t i) {
  const BoxLanes df;
  const float* planes = &node.lower[0][0];
  auto near = hn::Set(df, ray.tau_min);
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto plane = hn::Load(df, planes + ray.near_row[k] + i);
    near = max_unless_nan(
        df,
        hn::Mul(hn::Sub(plane, hn::Set(df, ray.near_origin[k])), hn::Set(df, ray.near_inverse[k])),
        near);
  }
  return near;
}
HWY_INLINE hn::Vec<BoxLanes> slab_far(const WideNode& node, const BoxRay& ray, float limit,
                                      std::size_t i) {
  const BoxLanes df;
  const float* planes = &node.lower[0][0];
  auto far = hn::Set(df, limit);
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto plane = hn::Load(df, planes + (BoxRay::kBothRows[k] - ray.near_row[k]) + i);
    far = min_unless_nan(
        df,
        hn::Mul(hn::Sub(plane, hn::Set(df, ray.far_origin[k])), hn::Set(df, ray.far_inverse[k])),
        far);
  }
  return far;
}

HWY_INLINE BoxCrossings cross_boxes(const WideNode& node, const BoxRay& ray, float limit) {
  BoxCrossings boxes;
  SIGHTLINE_UNROLL
  for (std::size_t v = 0; v < kBoxVectors; ++v) {
    boxes.near[v] = slab_near(node, ray, v * kBoxLanes);
    boxes.far[v] = slab_far(node, ray, limit, v * kBoxLanes);
  }
  return boxes;
}

/// Writes the children of a node that the ray meets before `limit`, the first to visit last, and
/// returns how many. Eight slots of both arrays may be overwritten.
template <Wanted kWanted>
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     std::uint32_t* HWY_RESTRICT ref_out,
                                     float* HWY_RESTRICT near_out) {
  const BoxCrossings boxes = cross_boxes(node, ray, limit);
  ChildList list(node, boxes);
  if constexpr (kWanted == Wanted::kNearest) list.sort(node, ray.octant);
  return list.store(ref_out, near_out);
}

/// Writes all children that push_children writes but the first to visit, which goes to `next`: a
/// ray on its own need not wait for the stack. Returns how many were written; `next` is kNoChild if
/// the ray meets none.
constexpr std::uint32_t kNoChild = 0xffffffffu;
template <Wanted kWanted>
HWY_INLINE std::size_t push_all_but_first(const WideNode& node, const BoxRay& ray, float limit,
                                          std::uint32_t* HWY_RESTRICT ref_out,
                                          float* HWY_RESTRICT near_out, std::uint32_t& next) {
  const BoxCrossings boxes = cross_boxes(node, ray, limit);
  ChildList list(node, boxes);
  std::uint32_t met = list.bits();
  next = kNoChild;
  if (met == 0) return 0;
  if ((met & (met - 1)) == 0) {
    // A single one needs no order.
    next = node.child[std::countr_zero(met)];
    return 0;
  }
  if constexpr (kWanted == Wanted::kNearest) {
    list.sort(node, ray.octant);
    met = list.bits();
  }
  auto first = static_cast<std::uint32_t>(31 - std::countl_zero(met));
  list.store(met ^ 1u << first, ref_out, near_out);
  if (kWanted == Wanted::kNearest) first = node.order[ray.octant] >> (3 * first) & 7u;
  next = node.child[first];
  return static_cast<std::size_t>(std::popcount(met)) - 1;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
