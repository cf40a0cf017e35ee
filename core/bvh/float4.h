#pragma once
/// Float4: four float32 values in one register, with the operations that the tree builder needs.
///
/// Written with the vector extensions of g++ and clang, which compile to SSE2 on x86-64 and NEON on
/// aarch64. Highway 1.0.3 has no vectors for baseline x86-64
/// (docs/decisions/0029-builder-by-vector-extensions.md). The results are identical on every
/// machine: min and max are defined lane by lane below, and no operation is fused.

#include <cstddef>

namespace sightline {

/// Four truth values: a lane is -1 (true) or 0 (false).
struct Mask4 {
  using Lanes = int __attribute__((vector_size(16)));
  Lanes v;
  /// The truth value of lane 0.
  bool first() const { return v[0] != 0; }
  friend Mask4 operator!(Mask4 mask) { return {~mask.v}; }
};

/// Four integers.
struct Int4 {
  using Lanes = int __attribute__((vector_size(16)));
  Lanes v;
  /// x in every lane.
  static Int4 all(int x) { return {Lanes{x, x, x, x}}; }
  int operator[](std::size_t lane) const { return v[lane]; }
  Int4& operator+=(Int4 other) {
    v += other.v;
    return *this;
  }
  /// yes in the lanes whose mask is true, no in the others.
  friend Int4 select(Mask4 mask, Int4 yes, Int4 no) { return {mask.v ? yes.v : no.v}; }
};

/// Four float32 values. Lanes are numbered from 0.
struct Float4 {
  using Lanes = float __attribute__((vector_size(16)));
  /// Lanes in memory. The memory may hold another type: the fourth value of a BuildBox is an
  /// integer.
  using Memory = float __attribute__((vector_size(16), may_alias));
  Lanes v;

  /// Reads p[0] to p[3]. Precondition: p is aligned to 16 bytes.
  static Float4 load(const float* p) {
    return {*static_cast<const Memory*>(__builtin_assume_aligned(p, 16))};
  }
  /// x, y, z, and 0 in lane 3.
  static Float4 of(float x, float y, float z) { return {Lanes{x, y, z, 0}}; }
  /// x in every lane.
  static Float4 all(float x) { return {Lanes{x, x, x, x}}; }
  /// Writes p[0] to p[3]. Precondition: p is aligned to 16 bytes.
  void store(float* p) const { *static_cast<Memory*>(__builtin_assume_aligned(p, 16)) = v; }

  friend Float4 operator+(Float4 a, Float4 b) { return {a.v + b.v}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {a.v - b.v}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {a.v * b.v}; }
  /// a < b ? a : b in each lane: b where a or b is NaN, and b where both are zeros.
  friend Float4 min(Float4 a, Float4 b) { return {a.v < b.v ? a.v : b.v}; }
  /// a > b ? a : b in each lane: b where a or b is NaN, and b where both are zeros.
  friend Float4 max(Float4 a, Float4 b) { return {a.v > b.v ? a.v : b.v}; }
  /// a < b in each lane.
  friend Mask4 less(Float4 a, Float4 b) { return {a.v < b.v}; }
  /// a <= b in each lane.
  friend Mask4 less_or_equal(Float4 a, Float4 b) { return {a.v <= b.v}; }

  /// x in the lanes whose mask is false, NaN in the others.
  friend Float4 nan_if(Mask4 mask, Float4 x) {
    return {__builtin_bit_cast(Lanes, __builtin_bit_cast(Mask4::Lanes, x.v) | mask.v)};
  }

  /// Lanes 0 to 2, and 0 in lane 3.
  Float4 without_last() const {
    return {__builtin_bit_cast(Lanes,
                               __builtin_bit_cast(Mask4::Lanes, v) & Mask4::Lanes{-1, -1, -1, 0})};
  }
  /// Lane 0.
  float first() const { return v[0]; }
  /// Lane kLane in every lane.
  template <int kLane>
  Float4 spread() const {
    return {__builtin_shufflevector(v, v, kLane, kLane, kLane, kLane)};
  }
  /// x*y + y*z + z*x of lanes 0 to 2, summed left to right. Of the sides of a box, this is half its
  /// surface area.
  float product_sum() const {
    const Lanes p = v * __builtin_shufflevector(v, v, 1, 2, 0, 3);
    return (p[0] + p[1]) + p[2];
  }
  /// Each lane rounded towards zero. Precondition: each result fits an int.
  Int4 truncated() const { return {__builtin_convertvector(v, Int4::Lanes)}; }
  /// The nearest float32 of each integer.
  static Float4 of(Int4 x) { return {__builtin_convertvector(x.v, Lanes)}; }
  /// product_sum() of a, b and c, in lanes 0 to 2; lane 3 has no meaning.
  static Float4 product_sums(Float4 a, Float4 b, Float4 c) {
    const Lanes xy = __builtin_shufflevector(a.v, b.v, 0, 4, 1, 5);
    const Lanes z = __builtin_shufflevector(a.v, b.v, 2, 6, 2, 6);
    const Lanes xs = __builtin_shufflevector(xy, c.v, 0, 1, 4, 4);
    const Lanes ys = __builtin_shufflevector(xy, c.v, 2, 3, 5, 5);
    const Lanes zs = __builtin_shufflevector(z, c.v, 0, 1, 6, 6);
    return {(xs * ys + ys * zs) + zs * xs};
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
