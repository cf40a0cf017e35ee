// Small things that every kernel file of one instruction set shares. Highway's per-target guard.

#if defined(SIGHTLINE_TRACE_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SIMD_INL_H_
#undef SIGHTLINE_TRACE_SIMD_INL_H_
#else
#define SIGHTLINE_TRACE_SIMD_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

// Loops over axes and corners must unroll, or their vectors live in memory.
#undef SIGHTLINE_UNROLL
#if defined(__clang__)
#define SIGHTLINE_UNROLL _Pragma("unroll")
#else
#define SIGHTLINE_UNROLL _Pragma("GCC unroll 8")
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// a unless it is NaN or smaller: NaN says nothing about a slab.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V max_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Max(a, b);  // maxps(a, b) is b if either is NaN
#else
  return hn::IfThenElse(hn::Gt(a, b), a, b);
#endif
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V min_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Min(a, b);
#else
  return hn::IfThenElse(hn::Lt(a, b), a, b);
#endif
}

/// Bit i says lane i; at most eight lanes.
template <class D, class M>
HWY_INLINE std::uint32_t mask_bits(D d, M mask) {
  HWY_ALIGN std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif
