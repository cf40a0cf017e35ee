#pragma once
/// Float4: four float32 values in one register, with the operations that the tree builder needs.
///
/// Written with the vector extensions of g++ and clang, which compile to SSE2 on x86-64 and NEON on
/// aarch64. Highway 1.0.3 has no vectors for baseline x86-64
/// (docs/decisions/0029-builder-by-vector-extensions.md). The results are identical on every
/// machine: min and max are defined lane by lane below, and no operation is fused.

#include <array>

namespace sightline {

/// Four truth values: a lane is -1 (true) or 0 (false).
struct Mask4 {
  using Lanes = int __attribute__((vector_size(16)));
  Lanes v;
  /// The truth value of lane 0.
  bool first() const { return v[0] != 0; }
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
  /// yes in the lanes whose mask is true, no in the others.
  friend Float4 select(Mask4 mask, Float4 yes, Float4 no) { return {mask.v ? yes.v : no.v}; }

  /// Lanes 0 to 2, and 0 in lane 3.
  Float4 without_last() const {
    return {__builtin_bit_cast(Lanes,
                               __builtin_bit_cast(Mask4::Lanes, v) & Mask4::Lanes{-1, -1, -1, 0})};
  }
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
  std::array<int, 4> truncated() const {
    const Mask4::Lanes whole = __builtin_convertvector(v, Mask4::Lanes);
    return {whole[0], whole[1], whole[2], whole[3]};
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
