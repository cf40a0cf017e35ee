#pragma once
/// Four float32 numbers in one register, just what the builder needs. Same results on every
/// machine: minimum and maximum are of ordinary numbers here, and nothing is fused.

#include <array>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace sightline {

#if defined(__SSE2__)

struct Float4 {
  __m128 v;
  static Float4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Float4 all(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  friend Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Float4 min(Float4 a, Float4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend Float4 max(Float4 a, Float4 b) { return {_mm_max_ps(a.v, b.v)}; }
  /// Truncates each; NaN and what does not fit become the most negative integer.
  void truncate(std::array<int, 4>& out) const {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out.data()), _mm_cvttps_epi32(v));
  }
};

#else

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
  friend Float4 min(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x < y ? x : y; });
  }
  friend Float4 max(Float4 a, Float4 b) {
    return each(a, b, [](float x, float y) { return x > y ? x : y; });
  }
  void truncate(std::array<int, 4>& out) const {
    for (int i = 0; i < 4; ++i) {
      const float x = v[i];
      out[static_cast<std::size_t>(i)] =
          x > -2147483648.0f && x < 2147483648.0f ? static_cast<int>(x) : -2147483647 - 1;
    }
  }
};

#endif

}  // namespace sightline
