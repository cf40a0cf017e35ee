#pragma once
/// Four float32 numbers in one register, just what the builder needs. Same results on every
/// machine: minimum and maximum are of ordinary numbers here, and nothing is fused.

#include <array>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace sightline {

#if defined(__SSE2__)

/// One truth value per lane.
struct Mask4 {
  __m128 v;
  bool first() const { return (_mm_movemask_ps(v) & 1) != 0; }
};

struct Float4 {
  __m128 v;
  static Float4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Float4 all(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  friend Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  /// b where a is NaN.
  friend Float4 min(Float4 a, Float4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend Float4 max(Float4 a, Float4 b) { return {_mm_max_ps(a.v, b.v)}; }
  friend Mask4 less(Float4 a, Float4 b) { return {_mm_cmplt_ps(a.v, b.v)}; }
  friend Float4 select(Mask4 mask, Float4 yes, Float4 no) {
    return {_mm_or_ps(_mm_and_ps(mask.v, yes.v), _mm_andnot_ps(mask.v, no.v))};
  }
  /// The fourth becomes 0.
  Float4 without_last() const {
    return {_mm_and_ps(v, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))};
  }
  /// Number `lane` in all four.
  template <int kLane>
  Float4 spread() const {
    return {_mm_shuffle_ps(v, v, _MM_SHUFFLE(kLane, kLane, kLane, kLane))};
  }
  /// (x y + y z) + z x.
  float product_sum() const {
    const __m128 p = _mm_mul_ps(v, _mm_shuffle_ps(v, v, _MM_SHUFFLE(3, 0, 2, 1)));
    const __m128 sum = _mm_add_ss(p, _mm_shuffle_ps(p, p, _MM_SHUFFLE(1, 1, 1, 1)));
    return _mm_cvtss_f32(_mm_add_ss(sum, _mm_movehl_ps(p, p)));
  }
  /// Towards zero. Precondition: each fits.
  std::array<int, 4> truncated() const {
    alignas(16) std::array<int, 4> out;
    _mm_store_si128(reinterpret_cast<__m128i*>(out.data()), _mm_cvttps_epi32(v));
    return out;
  }
};

#else

struct Mask4 {
  bool v[4];
  bool first() const { return v[0]; }
};

struct Float4 {
  float v[4];
  static Float4 load(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
  static Float4 all(float x) { return {{x, x, x, x}}; }
  void store(float* p) const {
    for (int i = 0; i < 4; ++i) p[i] = v[i];
  }
  template <class F>
  static Float4 each(Float4 a, Float4 b, F f) {
    for (int i = 0; i < 4; ++i) a.v[i] = f(a.v[i], b.v[i]);
    return a;
  }
  friend Float4 operator+(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x + y; });
  }
  friend Float4 operator-(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x - y; });
  }
  friend Float4 operator*(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x * y; });
  }
  /// b where a is NaN.
  friend Float4 min(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x < y ? x : y; });
  }
  friend Float4 max(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x > y ? x : y; });
  }
  friend Mask4 less(Float4 a, Float4 b) {
    Mask4 mask;
    for (int i = 0; i < 4; ++i) mask.v[i] = a.v[i] < b.v[i];
    return mask;
  }
  friend Float4 select(Mask4 mask, Float4 yes, Float4 no) {
    for (int i = 0; i < 4; ++i) yes.v[i] = mask.v[i] ? yes.v[i] : no.v[i];
    return yes;
  }
  /// The fourth becomes 0.
  Float4 without_last() const { return {{v[0], v[1], v[2], 0}}; }
  /// Number `lane` in all four.
  template <int kLane>
  Float4 spread() const {
    return all(v[kLane]);
  }
  /// (x y + y z) + z x.
  float product_sum() const { return (v[0] * v[1] + v[1] * v[2]) + v[2] * v[0]; }
  /// Towards zero. Precondition: each fits.
  std::array<int, 4> truncated() const {
    std::array<int, 4> out;
    for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<int>(v[i]);
    return out;
  }
};

#endif

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
