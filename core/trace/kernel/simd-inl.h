// Vector functions that all kernel files share. D, dd and d are Highway's tags of a vector type, V
// a vector of it. Compiled once for each instruction set, by Highway's include guard.

#if defined(SIGHTLINE_TRACE_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_SIMD_INL_H_
#undef SIGHTLINE_TRACE_SIMD_INL_H_
#else
#define SIGHTLINE_TRACE_SIMD_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

// Loops over axes and corners must be unrolled; otherwise their vectors are stored in memory.
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

/// The larger of a and b; b if a is NaN, because a NaN does not restrict a slab.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V max_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Max(a, b);  // maxps(a, b) is b if either is NaN
#else
  return hn::IfThenElse(hn::Gt(a, b), a, b);
#endif
}
/// The smaller of a and b; b if a is NaN.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V min_unless_nan(D, V a, V b) {
#if HWY_ARCH_X86
  return hn::Min(a, b);
#else
  return hn::IfThenElse(hn::Lt(a, b), a, b);
#endif
}

/// The larger of a and b; NaN if b is NaN. Precondition: a and b are products of one number with
/// two inverses of the same sign. If one product is 0 * inf, the other is 0, and b must be the
/// product with the larger inverse.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V nan_or_max(D d, V a, V b) {
  return max_unless_nan(d, a, b);
}

/// Rounds float64 to float32 as IEEE 754 does: what exceeds float32 becomes infinite. Highway's
/// emulated vectors return the largest float32 there.
template <class DF, class V>
HWY_INLINE hn::Vec<DF> to_float32(DF df, V v) {
#if HWY_TARGET == HWY_EMU128 || HWY_TARGET == HWY_SCALAR
  const hn::Rebind<double, DF> dd;
  HWY_ALIGN double from[hn::MaxLanes(dd)];
  HWY_ALIGN float to[hn::MaxLanes(dd)];
  hn::Store(v, dd, from);
  for (std::size_t i = 0; i < hn::Lanes(dd); ++i) to[i] = static_cast<float>(from[i]);
  return hn::Load(df, to);
#else
  return hn::DemoteTo(df, v);
#endif
}

/// The least of `count` aligned numbers. Precondition: count is not 0, and the numbers fill whole
/// vectors. NaN gives no defined result.
template <class D, class T = hn::TFromD<D>>
HWY_INLINE T least_of(D d, const T* values, std::size_t count) {
  auto low = hn::Load(d, values);
  for (std::size_t i = hn::Lanes(d); i < count; i += hn::Lanes(d))
    low = hn::Min(low, hn::Load(d, values + i));
  return hn::GetLane(hn::MinOfLanes(d, low));
}
/// The largest of such numbers.
template <class D, class T = hn::TFromD<D>>
HWY_INLINE T most_of(D d, const T* values, std::size_t count) {
  auto high = hn::Load(d, values);
  for (std::size_t i = hn::Lanes(d); i < count; i += hn::Lanes(d))
    high = hn::Max(high, hn::Load(d, values + i));
  return hn::GetLane(hn::MaxOfLanes(d, high));
}

/// Stores two vectors to consecutive addresses, in one store if there are vectors of twice the
/// size. A load that spans two stores would wait for both. Precondition: `to` is aligned to a
/// vector of twice the size.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void store_pair(D d, V low, V high, hn::TFromD<D>* to) {
#if HWY_TARGET != HWY_SCALAR  // has one lane, and no Combine
  if constexpr (2 * sizeof(hn::TFromD<D>) * hn::MaxLanes(D()) <= HWY_MAX_BYTES) {
    const hn::Twice<D> both;
    hn::Store(hn::Combine(both, high, low), both, to);
    return;
  }
#endif
  hn::Store(low, d, to);
  hn::Store(high, d, to + hn::Lanes(d));
}

static_assert(std::endian::native == std::endian::little);
/// The bits of a mask: bit i is set if lane i is true. Precondition: at most sixteen lanes.
template <class D, class M>
HWY_INLINE std::uint32_t mask_bits(D d, M mask) {
  HWY_ALIGN std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  if constexpr (hn::MaxLanes(d) <= 8) return bits[0];
  std::uint16_t both = 0;  // as one number: the lowest byte first, as lanes are
  std::memcpy(&both, bits, sizeof both);
  return both;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
