// Tests a ray against the eight boxes of a node at once [Wald2008].

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

/// Prefetches a node, or the first sizeof(WideNode) bytes of a leaf.
HWY_INLINE void fetch_node(const std::byte* target) {
  SIGHTLINE_UNROLL
  for (std::size_t i = 0; i < sizeof(WideNode); i += 64) hwy::Prefetch(target + i);
}

/// Elements of the stack of a ray in flight, or of a packet.
constexpr std::size_t kWaiting = 248;

/// The entry distances of a ray for the boxes of a node from box `i` on, as many as a vector has
/// lanes. Slab test [Kay1986]; never above the exact distances, as BoxRay states. In tree units of
/// tau.
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
/// The exit distances for these boxes, at most `limit`; never below the exact ones.
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

/// Both distances for all boxes of a node. `limit` is BoxRay::limit: hits beyond it do not matter.
HWY_INLINE BoxCrossings cross_boxes(const WideNode& node, const BoxRay& ray, float limit) {
  BoxCrossings boxes;
  SIGHTLINE_UNROLL
  for (std::size_t v = 0; v < kBoxVectors; ++v) {
    boxes.near[v] = slab_near(node, ray, v * kBoxLanes);
    boxes.far[v] = slab_far(node, ray, limit, v * kBoxLanes);
  }
  return boxes;
}

/// Writes references and entry distances of the children that the ray meets before `limit`, the
/// first to visit last, and returns their number. Eight elements of both arrays may be overwritten.
template <Wanted kWanted>
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     std::uint32_t* HWY_RESTRICT ref_out,
                                     float* HWY_RESTRICT near_out) {
  const BoxCrossings boxes = cross_boxes(node, ray, limit);
  ChildList list(node, boxes);
  if constexpr (kWanted == Wanted::kNearest) list.sort(node, ray.octant);
  return list.store(ref_out, near_out);
}

/// The result of push_all_but_first if the ray meets no child.
constexpr std::uint32_t kNoChild = 0xffffffffu;
/// push_children without the child to visit first, which is returned in `next`: a single ray then
/// does not wait for the stack. Returns the number of children written; `next` is kNoChild if the
/// ray meets none.
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
    // A single child needs no sorting.
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
