// Tests a ray against the eight boxes of a node at once [Wald2008].

#if defined(SIGHTLINE_TRACE_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SLABS_INL_H_
#undef SIGHTLINE_TRACE_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_SLABS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <array>

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

/// The vectors of a BoxRay for a single ray: each number in all lanes, so that no node broadcasts
/// it again. Members are those of BoxRay.
struct BoxRayLanes {
  using V = hn::Vec<BoxLanes>;
  V near_origin[3], far_origin[3], near_inverse[3], far_inverse[3];
  V tau_min;

  HWY_INLINE explicit BoxRayLanes(const BoxRay& ray) : tau_min(hn::Set(BoxLanes(), ray.tau_min)) {
    const BoxLanes df;
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      near_origin[k] = hn::Set(df, ray.near_origin[k]);
      far_origin[k] = hn::Set(df, ray.far_origin[k]);
      near_inverse[k] = hn::Set(df, ray.near_inverse[k]);
      far_inverse[k] = hn::Set(df, ray.far_inverse[k]);
    }
  }
};
/// A number of a ray in all lanes.
HWY_INLINE hn::Vec<BoxLanes> in_lanes(float number) { return hn::Set(BoxLanes(), number); }
HWY_INLINE hn::Vec<BoxLanes> in_lanes(hn::Vec<BoxLanes> numbers) { return numbers; }
/// BoxRay::near_row.
template <class Offset>
using NearRows = std::array<Offset, 3>;

/// The entry distances of a ray (BoxRay or BoxRayLanes) for the boxes of a node from box `i` on, as
/// many as a vector has lanes. Slab test [Kay1986]; never above the exact distances, as BoxRay
/// states. In tree units of tau.
template <class BoxRayOf, class Offset>
HWY_INLINE hn::Vec<BoxLanes> slab_near(const WideNode& node, const BoxRayOf& ray,
                                       const NearRows<Offset>& near_row, std::size_t i) {
  const BoxLanes df;
  const float* planes = &node.lower[0][0];
  auto near = in_lanes(ray.tau_min);
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto plane = hn::Load(df, planes + near_row[k] + i);
    near = max_unless_nan(
        df, hn::Mul(hn::Sub(plane, in_lanes(ray.near_origin[k])), in_lanes(ray.near_inverse[k])),
        near);
  }
  return near;
}
/// The exit distances for these boxes, at most `limit`; never below the exact ones.
template <class BoxRayOf, class Offset>
HWY_INLINE hn::Vec<BoxLanes> slab_far(const WideNode& node, const BoxRayOf& ray,
                                      const NearRows<Offset>& near_row, hn::Vec<BoxLanes> limit,
                                      std::size_t i) {
  const BoxLanes df;
  const float* planes = &node.lower[0][0];
  auto far = limit;
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const auto plane = hn::Load(df, planes + (BoxRay::kBothRows[k] ^ near_row[k]) + i);
    far = min_unless_nan(
        df, hn::Mul(hn::Sub(plane, in_lanes(ray.far_origin[k])), in_lanes(ray.far_inverse[k])),
        far);
  }
  return far;
}

/// Both distances for all boxes of a node. `limit` is BoxRay::limit in all lanes: hits beyond it do
/// not matter.
template <class BoxRayOf, class Offset>
HWY_INLINE BoxCrossings cross_boxes(const WideNode& node, const BoxRayOf& ray,
                                    const NearRows<Offset>& near_row, hn::Vec<BoxLanes> limit) {
  BoxCrossings boxes;
  SIGHTLINE_UNROLL
  for (std::size_t v = 0; v < kBoxVectors; ++v) {
    boxes.near[v] = slab_near(node, ray, near_row, v * kBoxLanes);
    boxes.far[v] = slab_far(node, ray, near_row, limit, v * kBoxLanes);
  }
  return boxes;
}

/// Writes references and entry distances of the children that the ray meets before `limit`, the
/// first to visit last, and returns their number. If kWanted is Wanted::kAny, no distances are
/// written, and near_out may be null. Eight elements of both arrays may be overwritten.
template <Wanted kWanted>
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     std::uint32_t* HWY_RESTRICT ref_out,
                                     float* HWY_RESTRICT near_out) {
  const BoxCrossings boxes = cross_boxes(node, ray, ray.near_row, in_lanes(limit));
  ChildList list(node, boxes);
  if constexpr (kWanted == Wanted::kAny) return list.store(ref_out);
  list.sort(node, ray.octant);
  return list.store(ref_out, near_out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
