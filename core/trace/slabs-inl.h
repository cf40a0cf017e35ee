// Ray against the eight boxes of a node.

#if defined(SIGHTLINE_TRACE_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SLABS_INL_H_
#undef SIGHTLINE_TRACE_SLABS_INL_H_
#else
#define SIGHTLINE_TRACE_SLABS_INL_H_
#endif

#include "core/bvh/wide_tree.h"
#include "core/trace/ray_setup.h"
#include "core/trace/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// The children of a node from far to near for rays of that octant: as many as a vector holds.
HWY_INLINE hn::Vec<hn::CappedTag<std::uint32_t, kArity>> child_order(const WideNode& node,
                                                                     std::uint32_t octant) {
  const hn::CappedTag<std::uint32_t, kArity> du;
  // The permutation is eight fields of three bits; table lookups look at the low three bits only.
  return hn::And(hn::Shr(hn::Set(du, node.order[octant]), hn::Mul(hn::Iota(du, 0), hn::Set(du, 3))),
                 hn::Set(du, 7));
}

/// Writes the children of a node that the ray meets before `limit`, the nearest last, and returns
/// how many. Eight slots of both arrays may be overwritten. [Kay1986] slabs, conservative as BoxRay
/// says; the order of children is the octant's.
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     std::uint32_t* HWY_RESTRICT ref_out,
                                     float* HWY_RESTRICT near_out) {
  const hn::CappedTag<float, kArity> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::uint32_t o = ray.octant;
  const float* planes = &node.lower[0][0];
  const auto slab_near = [&](std::size_t i) {
    auto near = hn::Set(df, ray.tau_min);
    SIGHTLINE_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
      const auto plane = hn::Load(df, planes + ray.near_row[k] + i);
      near = max_unless_nan(df,
                            hn::Mul(hn::Sub(plane, hn::Set(df, ray.near_origin[k])),
                                    hn::Set(df, ray.near_inverse[k])),
                            near);
    }
    return near;
  };
  const auto slab_far = [&](std::size_t i) {
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
  };
#if HWY_MAX_BYTES >= 32
  const auto near = slab_near(0);
  const auto far = slab_far(0);
  const auto rank = child_order(node, o);
  const auto index = hn::IndicesFromVec(df, rank);
  const auto near_sorted = hn::TableLookupLanes(near, index);
  const auto far_sorted = hn::TableLookupLanes(far, index);
  const auto ref_sorted =
      hn::TableLookupLanes(hn::Load(du, node.child), hn::IndicesFromVec(du, rank));
  const auto hit = hn::Le(near_sorted, far_sorted);
  // Compressed in registers: a compressing store would keep the next pop waiting.
  hn::StoreU(hn::Compress(near_sorted, hit), df, near_out);
  hn::StoreU(hn::Compress(ref_sorted, hn::RebindMask(du, hit)), du, ref_out);
  return hn::CountTrue(df, hit);
#else
  HWY_ALIGN float near[kArity];
  HWY_ALIGN float far[kArity];
  (void)du;
  for (std::size_t i = 0; i < kArity; i += hn::Lanes(df)) {
    hn::Store(slab_near(i), df, near + i);
    hn::Store(slab_far(i), df, far + i);
  }
  std::uint32_t order = node.order[o];
  std::size_t size = 0;
  for (std::size_t i = 0; i < kArity; ++i, order >>= 3) {
    const std::uint32_t child = order & 7u;
    ref_out[size] = node.child[child];
    near_out[size] = near[child];
    size += near[child] <= far[child] ? 1 : 0;
  }
  return size;
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
