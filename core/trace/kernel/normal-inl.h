// Unit normals of triangles, in double-double where that can be certified.
// docs/explanation/exactness.md, "What is asked of a hit".

#if defined(SIGHTLINE_TRACE_NORMAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_TRACE_NORMAL_INL_H_
#undef SIGHTLINE_TRACE_NORMAL_INL_H_
#else
#define SIGHTLINE_TRACE_NORMAL_INL_H_
#endif

#include "core/geometry/exact_hit.h"
#include "core/trace/kernel/double_double-inl.h"
#include "core/trace/kernel/kernel.h"

HWY_BEFORE_NAMESPACE();
namespace sightline {
namespace HWY_NAMESPACE {

/// True in the lanes that are zero.
template <class V>
HWY_INLINE auto is_zero(V value) {
  return hn::Eq(value, hn::Zero(hn::DFromV<V>()));
}
/// True in the lanes in which a product is zero because a factor is, not because it underflowed.
template <class V>
HWY_INLINE auto is_zero(V a, V b) {
  return hn::Or(is_zero(a), is_zero(b));
}
/// True in the lanes whose value is so large that no step underflowed, or is exactly zero
/// (`vanishes`).
template <class V, class M>
HWY_INLINE auto nowhere_near_underflow(V value, M vanishes) {
  return hn::Or(hn::Ge(hn::Abs(value), hn::Set(hn::DFromV<V>(), 0x1p-900)), vanishes);
}

/// Stores n / sqrt(n.n) to out[axis]. Returns true in the lanes where each component is certainly
/// the exact component rounded once. Precondition: no NormalOf::size is beyond kLargestFactor, or
/// the lanes in which one is are not used.
template <class Tag>
HWY_INLINE hn::Mask<Tag> store_unit(const EdgesOf<Tag>& edges, const NormalOf<Tag>& normal,
                                    double* const (&out)[3]) {
  using Pair = DoubleDoubleOf<Tag>;
  using V = hn::Vec<Tag>;
  const Tag dd;
  const V zero = hn::Zero(dd);
  const V unit = hn::Set(dd, bounds::kDoubleDouble);
  Pair square;
  V square_size = zero;
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    square = k == 0 ? normal.n[k] * normal.n[k] : square + normal.n[k] * normal.n[k];
    square_size = hn::MulAdd(hn::Abs(normal.n[k].high), normal.size[k], square_size);
  }
  auto good = hn::Ge(square.high, hn::Set(dd, 0x1p-600));
  const V root = hn::Sqrt(square.high);
  const Pair root_square = Pair::two_product(root, root);
  const V root_rest =
      hn::Add(hn::Sub(hn::Sub(square.high, root_square.high), root_square.low), square.low);
  const V inverse_root = hn::Div(hn::Set(dd, 1.0), root);
  const Pair length =
      Pair::fast_two_sum(root, hn::Mul(hn::Mul(root_rest, hn::Set(dd, 0.5)), inverse_root));
  const V relative = hn::Add(hn::Div(square_size, square.high), hn::Set(dd, 1.0));
  SIGHTLINE_UNROLL
  for (std::size_t k = 0; k < 3; ++k) {
    const V q = hn::Mul(normal.n[k].high, inverse_root);
    const Pair p = q * length;
    const V rest = hn::Add(hn::Sub(normal.n[k].high, p.high), hn::Sub(normal.n[k].low, p.low));
    const Pair component = Pair::fast_two_sum(q, hn::Mul(rest, inverse_root));
    const V error = hn::Mul(
        unit, hn::MulAdd(normal.size[k], inverse_root, hn::Mul(hn::Abs(component.high), relative)));
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    const auto vanishes = hn::And(is_zero(edges.e1[i].high, edges.e2[j].high),
                                  is_zero(edges.e1[j].high, edges.e2[i].high));
    good = hn::And(
        good, hn::And(component.certain(error), nowhere_near_underflow(component.high, vanishes)));
    hn::StoreU(hn::Add(component.high, zero), dd, out[k]);
  }
  return good;
}

/// Computes normals of hits, several triangles at a time: add() each hit, then flush().
/// Neighbouring hits of one triangle are computed once. The arguments of the constructor must
/// outlive it.
class Normals {
 public:
  Normals(const Scene& scene, const HitBatch& hits, Vec3d* out)
      : scene_(scene), hits_(hits), out_(out) {}

  /// Adds the hit of a slot; results of earlier hits may be written to `out`. Precondition: the
  /// slot is no miss.
  void add(std::size_t hit) {
    const TriangleId id = hits_.id(hit);
    if (size_ > 0 && last_ == id && end_[size_ - 1] == hit) {
      ++end_[size_ - 1];
      return;
    }
    if (size_ == kGroup) flush();
    last_ = id;
    const Triangle triangle = scene_.world_triangle(id);
    const Vec3d* corner[3] = {&triangle.v0, &triangle.v1, &triangle.v2};
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) corner_[c][k][size_] = (*corner[c])[k];
    }
    begin_[size_] = hit;
    end_[size_++] = hit + 1;
  }

  /// Writes the results that remain.
  void flush() {
    if (size_ == 0) return;
    for (std::size_t i = size_; i < kGroup; ++i) {
      for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) corner_[c][k][i] = corner_[c][k][0];
      }
    }
    std::uint32_t certain = 0;
    for (std::size_t i = 0; i < kGroup; i += hn::Lanes(D())) certain |= compute(i) << i;
    for (std::size_t i = 0; i < size_; ++i) {
      const Vec3d normal = (certain >> i & 1u) != 0
                               ? Vec3d{normal_[0][i], normal_[1][i], normal_[2][i]}
                               : exact_normal(scene_.world_triangle(hits_.id(begin_[i])));
      for (std::size_t hit = begin_[i]; hit < end_[i]; ++hit) out_[hit] = normal;
    }
    size_ = 0;
  }

 private:
  static constexpr std::size_t kGroup = 8;
  using D = DoubleDouble::D;

  /// Bit i: the normal of lane at + i is certainly the exact one rounded once.
  HWY_INLINE std::uint32_t compute(std::size_t at) {
    const D dd;
    const double* corner[3][3];
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 3; ++k) corner[c][k] = corner_[c][k] + at;
    }
    const EdgesOf<D> edges(corner);
    const NormalOf<D> normal(edges);
    double* const out[3] = {normal_[0] + at, normal_[1] + at, normal_[2] + at};
    auto good = store_unit(edges, normal, out);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const auto vanishes = hn::And(is_zero(edges.e1[i].high, edges.e2[j].high),
                                    is_zero(edges.e1[j].high, edges.e2[i].high));
      // Then products that underflow are no part of the sum.
      const auto sized = hn::Or(hn::Ge(normal.size[k], hn::Set(dd, 0x1p-600)), vanishes);
      good = hn::And(good, hn::And(sized, hn::Le(normal.size[k], hn::Set(dd, kLargestFactor))));
    }
    return mask_bits(dd, good);
  }

  const Scene& scene_;
  const HitBatch& hits_;
  Vec3d* out_;
  std::size_t size_ = 0;
  TriangleId last_;
  std::size_t begin_[kGroup], end_[kGroup];  ///< the hits of each triangle
  HWY_ALIGN double corner_[3][3][kGroup];
  HWY_ALIGN double normal_[3][kGroup];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline
HWY_AFTER_NAMESPACE();

#endif

// Tests: tests/unit/trace/kernel_test.cpp
