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

/// Starts fetching a node, or as much of a leaf.
HWY_INLINE void fetch_node(const std::byte* target) {
  SIGHTLINE_UNROLL
  for (std::size_t i = 0; i < sizeof(WideNode); i += 64) hwy::Prefetch(target + i);
}

/// Siblings that may wait, of one ray in flight or one packet.
constexpr std::size_t kWaiting = 248;

using BoxLanes = hn::CappedTag<float, kArity>;

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

/// Which child is visited first: the nearest one, as the ray's octant has it, or the one in the
/// last slot, where builders put what is most likely worth a look if any hit will do.
enum class Wanted { kNearest, kAny };

#if HWY_MAX_BYTES >= 32
/// The children of a node: where the ray enters and leaves their boxes.
struct Children {
  hn::Vec<BoxLanes> near, far;
  hn::Vec<hn::RebindToUnsigned<BoxLanes>> ref;

  HWY_INLINE Children(const WideNode& node, const BoxRay& ray, float limit)
      : near(slab_near(node, ray, 0)),
        far(slab_far(node, ray, limit, 0)),
        ref(hn::Load(hn::RebindToUnsigned<BoxLanes>(), node.child)) {}
  /// The first to visit last.
  template <Wanted kWanted>
  HWY_INLINE void sort(const WideNode& node, std::uint32_t octant) {
    if constexpr (kWanted == Wanted::kAny) return;
    const BoxLanes df;
    const auto rank = child_order(node, octant);
    const auto index = hn::IndicesFromVec(df, rank);
    near = hn::TableLookupLanes(near, index);
    far = hn::TableLookupLanes(far, index);
    ref = hn::TableLookupLanes(ref, hn::IndicesFromVec(hn::RebindToUnsigned<BoxLanes>(), rank));
  }
  HWY_INLINE hn::Mask<BoxLanes> met() const { return hn::Le(near, far); }
};
#endif

/// Writes the children of a node that the ray meets before `limit`, the first to visit last, and
/// returns how many. Eight slots of both arrays may be overwritten.
template <Wanted kWanted>
HWY_INLINE std::size_t push_children(const WideNode& node, const BoxRay& ray, float limit,
                                     std::uint32_t* HWY_RESTRICT ref_out,
                                     float* HWY_RESTRICT near_out) {
  const BoxLanes df;
#if HWY_MAX_BYTES >= 32
  const hn::RebindToUnsigned<BoxLanes> du;
  Children children(node, ray, limit);
  children.sort<kWanted>(node, ray.octant);
  const auto met = children.met();
  // Compressed in registers: a compressing store would keep the next pop waiting.
  hn::StoreU(hn::Compress(children.near, met), df, near_out);
  hn::StoreU(hn::Compress(children.ref, hn::RebindMask(du, met)), du, ref_out);
  return hn::CountTrue(df, met);
#else
  HWY_ALIGN float near[kArity];
  HWY_ALIGN float far[kArity];
  for (std::size_t i = 0; i < kArity; i += hn::Lanes(df)) {
    hn::Store(slab_near(node, ray, i), df, near + i);
    hn::Store(slab_far(node, ray, limit, i), df, far + i);
  }
  std::uint32_t order = kWanted == Wanted::kNearest ? node.order[ray.octant] : 076543210u;
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

/// The same but for the first to visit, which goes to `next`: a ray on its own need not wait for
/// the stack. Returns how many were written; `next` is kNoChild if the ray meets none.
constexpr std::uint32_t kNoChild = 0xffffffffu;
template <Wanted kWanted>
HWY_INLINE std::size_t push_all_but_first(const WideNode& node, const BoxRay& ray, float limit,
                                          std::uint32_t* HWY_RESTRICT ref_out,
                                          float* HWY_RESTRICT near_out, std::uint32_t& next) {
#if HWY_MAX_BYTES >= 32
  const BoxLanes df;
  const hn::RebindToUnsigned<BoxLanes> du;
  Children children(node, ray, limit);
  std::uint32_t met = mask_bits(df, children.met());
  next = kNoChild;
  if (met == 0) return 0;
  if ((met & (met - 1)) == 0) {
    // A single one needs no order.
    next = node.child[std::countr_zero(met)];
    return 0;
  }
  children.sort<kWanted>(node, ray.octant);
  if (kWanted == Wanted::kNearest) met = mask_bits(df, children.met());
  auto first = static_cast<std::uint32_t>(31 - std::countl_zero(met));
  const auto others = static_cast<std::uint8_t>(met ^ 1u << first);
  if (kWanted == Wanted::kNearest) first = node.order[ray.octant] >> (3 * first) & 7u;
  next = node.child[first];
  const auto waiting = hn::LoadMaskBits(df, &others);
  hn::StoreU(hn::Compress(children.near, waiting), df, near_out);
  hn::StoreU(hn::Compress(children.ref, hn::RebindMask(du, waiting)), du, ref_out);
  return static_cast<std::size_t>(std::popcount(met)) - 1;
#else
  const std::size_t found = push_children<kWanted>(node, ray, limit, ref_out, near_out);
  next = found > 0 ? ref_out[found - 1] : kNoChild;
  return found > 0 ? found - 1 : 0;
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
