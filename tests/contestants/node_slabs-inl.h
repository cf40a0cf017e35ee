// Ray against the eight boxes of a node, for contestants: conservative for float64 rays, so that no
// box takes a hit away from a triangle test. Highway's per-target guard.

#if defined(SIGHTLINE_CONTESTANTS_NODE_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_CONTESTANTS_NODE_SLABS_INL_H_
#undef SIGHTLINE_CONTESTANTS_NODE_SLABS_INL_H_
#else
#define SIGHTLINE_CONTESTANTS_NODE_SLABS_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstdint>

#include "core/bvh/wide_tree.h"
#include "core/query/ray_batch.h"
#include "core/trace/kernel/child_list-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::contestants {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Bit i says lane i; at most eight lanes.
template <class D, class M>
HWY_INLINE std::uint32_t mask_bits(D d, M mask) {
  HWY_ALIGN std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

/// near = (plane - near_origin) * near_inverse is not later, far not earlier than the exact t of
/// the planes, for t >= 0: origins and inverses are moved by more than their roundings.
struct SlabRay {
  float near_origin[3], far_origin[3], near_inverse[3], far_inverse[3];
  std::uint32_t near_row[3], far_row[3];  ///< of the planes in a WideNode, in float32
  std::uint32_t octant = 0;
  float tmin = 0;

  HWY_INLINE void set(const Ray& ray) {
    octant = 0;
    for (int k = 0; k < 3; ++k) {
      const bool negative = std::signbit(ray.direction[k]);
      const double o = ray.origin[k], step = std::abs(o) * 0x1p-22 + 0x1p-140;
      const auto below = static_cast<float>(o - step), above = static_cast<float>(o + step);
      const double inverse = 1 / ray.direction[k];
      near_origin[k] = negative ? below : above;
      far_origin[k] = negative ? above : below;
      near_inverse[k] = static_cast<float>(inverse * (1 - 0x1p-20));
      far_inverse[k] = static_cast<float>(inverse * (1 + 0x1p-20));
      const auto axis = static_cast<std::uint32_t>(k);
      near_row[k] = axis * 8 + (negative ? 24 : 0);
      far_row[k] = axis * 8 + (negative ? 0 : 24);
      octant |= (negative ? 1u : 0u) << axis;
    }
    tmin = static_cast<float>(ray.tmin * (1 - 0x1p-20));
  }
};

/// Writes the children that the ray meets before `limit`, in the octant's order, the nearest last,
/// and returns how many. Eight slots of both arrays may be overwritten. [Kay1986]
HWY_INLINE std::size_t push_met_children(const WideNode& node, const SlabRay& ray, float limit,
                                         std::uint32_t* ref_out, float* near_out) {
  const hn::CappedTag<float, kArity> d;
  using V = hn::Vec<decltype(d)>;
  const float* planes = &node.lower[0][0];
  const auto slabs = [&](std::size_t i, V& near, V& far) {
    near = hn::Set(d, ray.tmin);
    far = hn::Set(d, limit);
    for (int k = 0; k < 3; ++k) {
      const V enter = hn::Mul(
          hn::Sub(hn::Load(d, planes + ray.near_row[k] + i), hn::Set(d, ray.near_origin[k])),
          hn::Set(d, ray.near_inverse[k]));
      const V leave =
          hn::Mul(hn::Sub(hn::Load(d, planes + ray.far_row[k] + i), hn::Set(d, ray.far_origin[k])),
                  hn::Set(d, ray.far_inverse[k]));
      // NaN (a plane through the origin of a parallel ray) says nothing.
#if HWY_ARCH_X86
      near = hn::Max(enter, near);  // the second operand if one is NaN
      far = hn::Min(leave, far);
#else
      near = hn::IfThenElse(hn::Gt(enter, near), enter, near);
      far = hn::IfThenElse(hn::Lt(leave, far), leave, far);
#endif
    }
  };
  sightline::HWY_NAMESPACE::BoxCrossings boxes;
  for (std::size_t v = 0; v < kArity / hn::MaxLanes(d); ++v)
    slabs(v * hn::MaxLanes(d), boxes.near[v], boxes.far[v]);
  sightline::HWY_NAMESPACE::ChildList list(node, boxes);
  list.sort(node, ray.octant);
  return list.store(ref_out, near_out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::contestants
HWY_AFTER_NAMESPACE();

#endif
