// Ray-triangle tests of the literature on the four lanes of a leaf block, as their authors compute
// them and without epsilons. Highway's per-target guard.
//
// Each test has
//   Real              the number format in which it computes
//   State             what it keeps of a ray
//   prepare(ray)      a State
//   meet(block, state, t)
//                     bit i: triangle i is met at t[i]; the ray's limits are not looked at

#if defined(SIGHTLINE_CONTESTANTS_TRIANGLE_TESTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_CONTESTANTS_TRIANGLE_TESTS_INL_H_
#undef SIGHTLINE_CONTESTANTS_TRIANGLE_TESTS_INL_H_
#else
#define SIGHTLINE_CONTESTANTS_TRIANGLE_TESTS_INL_H_
#endif

#include <cmath>
#include <utility>

#include "core/bvh/wide_tree.h"
#include "core/query/ray_batch.h"
#include "core/trace/kernel/filter-inl.h"
#include "tests/contestants/node_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::contestants {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using sightline::HWY_NAMESPACE::CornerLoader;

template <class V>
struct Vectors {
  V x, y, z;
};

template <class V>
HWY_INLINE Vectors<V> minus(const Vectors<V>& a, const Vectors<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V>
HWY_INLINE Vectors<V> plus(const Vectors<V>& a, const Vectors<V>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V>
HWY_INLINE Vectors<V> cross(const Vectors<V>& a, const Vectors<V>& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE V dot(const Vectors<V>& a, const Vectors<V>& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

/// The corners of the lanes of a block from i on.
template <class D>
struct BlockCorners {
  Vectors<hn::Vec<D>> at[3];

  HWY_INLINE BlockCorners(D, const LeafBlock& block, std::size_t i) {
    const CornerLoader<D> loader(block, i);
    hn::Vec<D> x[3], y[3], z[3];
    loader.load(0, x);
    loader.load(1, y);
    loader.load(2, z);
    for (std::size_t c = 0; c < 3; ++c) at[c] = {x[c], y[c], z[c]};
  }
};

template <class Number>
struct RayNumbers {
  Number origin[3], direction[3];
};

template <class Number>
RayNumbers<Number> numbers_of(const Ray& ray) {
  RayNumbers<Number> numbers;
  for (int k = 0; k < 3; ++k) {
    numbers.origin[k] = static_cast<Number>(ray.origin[k]);
    numbers.direction[k] = static_cast<Number>(ray.direction[k]);
  }
  return numbers;
}

template <class D, class Number>
HWY_INLINE Vectors<hn::Vec<D>> set3(D d, const Number* v) {
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

template <class M, class D>
HWY_INLINE std::uint32_t bits_of(D d, M mask, std::size_t i) {
  return mask_bits(d, mask) << i;
}

/// [Moeller1997], the form that divides.
template <class Number>
struct MoellerTrumbore {
  using Real = Number;
  using State = RayNumbers<Number>;

  static State prepare(const Ray& ray) { return numbers_of<Number>(ray); }

  static HWY_INLINE std::uint32_t meet(const LeafBlock& block, const State& ray, Number* t) {
    const hn::CappedTag<Number, kLanes> d;
    std::uint32_t met = 0;
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
      const BlockCorners corners(d, block, i);
      const auto v0 = corners.at[0];
      const auto e1 = minus(corners.at[1], v0);
      const auto e2 = minus(corners.at[2], v0);
      const auto direction = set3(d, ray.direction);
      const auto p = cross(direction, e2);
      const auto inverse = hn::Div(hn::Set(d, Number{1}), dot(e1, p));
      const auto s = minus(set3(d, ray.origin), v0);
      const auto u = hn::Mul(dot(s, p), inverse);
      const auto q = cross(s, e1);
      const auto v = hn::Mul(dot(direction, q), inverse);
      hn::StoreU(hn::Mul(dot(e2, q), inverse), d, t + i);
      // A determinant of zero makes these infinite or NaN: not in the range.
      const auto zero = hn::Zero(d);
      const auto in = hn::And(hn::And(hn::Ge(u, zero), hn::Ge(v, zero)),
                              hn::Le(hn::Add(u, v), hn::Set(d, Number{1})));
      met |= bits_of(d, in, i);
    }
    return met;
  }
};

/// [Woop2013], appendix A: float32, the edge functions again in float64 when one of them is zero.
/// No fused operations in them: neighbours must get the same product for a shared edge.
struct WoopWatertight {
  using Real = float;
  struct State {
    float origin[3];  ///< on the axes kx, ky, kz
    float shear_x, shear_y, shear_z;
    std::uint32_t axis[3];
  };

  static State prepare(const Ray& ray) {
    const RayNumbers<float> numbers = numbers_of<float>(ray);
    const float* d = numbers.direction;
    std::uint32_t kz = std::fabs(d[0]) > std::fabs(d[1]) ? 0 : 1;
    if (std::fabs(d[2]) > std::fabs(d[kz])) kz = 2;
    std::uint32_t kx = (kz + 1) % 3, ky = (kx + 1) % 3;
    if (d[kz] < 0) std::swap(kx, ky);
    return {{numbers.origin[kx], numbers.origin[ky], numbers.origin[kz]},
            d[kx] / d[kz],
            d[ky] / d[kz],
            1 / d[kz],
            {kx, ky, kz}};
  }

  static HWY_INLINE std::uint32_t meet(const LeafBlock& block, const State& ray, float* t) {
    const hn::CappedTag<float, kLanes> d;
    using V = hn::Vec<decltype(d)>;
    V x[3], y[3], z[3];
    const CornerLoader<decltype(d)> loader(block, 0);
    loader.load(ray.axis[0], x);
    loader.load(ray.axis[1], y);
    loader.load(ray.axis[2], z);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto seen = [&](const V& v, std::size_t k) {
        return hn::Sub(v, hn::Set(d, ray.origin[k]));
      };
      const V along = seen(z[c], 2);
      x[c] = hn::Sub(seen(x[c], 0), hn::Mul(hn::Set(d, ray.shear_x), along));
      y[c] = hn::Sub(seen(y[c], 1), hn::Mul(hn::Set(d, ray.shear_y), along));
      z[c] = hn::Mul(hn::Set(d, ray.shear_z), along);
    }
    V w0 = edge(x[2], y[1], y[2], x[1]);
    V w1 = edge(x[0], y[2], y[0], x[2]);
    V w2 = edge(x[1], y[0], y[1], x[0]);
    const V zero = hn::Zero(d);
    const auto on_edge = hn::Or(hn::Or(hn::Eq(w0, zero), hn::Eq(w1, zero)), hn::Eq(w2, zero));
    if (HWY_UNLIKELY(!hn::AllFalse(d, on_edge))) {
      w0 = edge_again(x[2], y[1], y[2], x[1]);
      w1 = edge_again(x[0], y[2], y[0], x[2]);
      w2 = edge_again(x[1], y[0], y[1], x[0]);
    }
    const V least = hn::Min(w0, hn::Min(w1, w2));
    const V most = hn::Max(w0, hn::Max(w1, w2));
    const V determinant = hn::Add(hn::Add(w0, w1), w2);
    const auto in =
        hn::AndNot(hn::Eq(determinant, zero), hn::Or(hn::Ge(least, zero), hn::Le(most, zero)));
    const V sum = hn::Add(hn::Add(hn::Mul(w0, z[0]), hn::Mul(w1, z[1])), hn::Mul(w2, z[2]));
    hn::StoreU(hn::Div(sum, determinant), d, t);
    return mask_bits(d, in);
  }

 private:
  template <class V>
  static HWY_INLINE V edge(V a, V b, V c, V e) {
    return hn::Sub(hn::Mul(a, b), hn::Mul(c, e));
  }
  template <class V>
  static HWY_INLINE V edge_again(V a, V b, V c, V e) {
    const hn::CappedTag<float, kLanes> d;
    float lanes[4][kLanes];
    hn::StoreU(a, d, lanes[0]);
    hn::StoreU(b, d, lanes[1]);
    hn::StoreU(c, d, lanes[2]);
    hn::StoreU(e, d, lanes[3]);
    for (std::size_t i = 0; i < kLanes; ++i) {
      using Wide = double;
      lanes[0][i] = static_cast<float>(Wide{lanes[0][i]} * Wide{lanes[1][i]} -
                                       Wide{lanes[2][i]} * Wide{lanes[3][i]});
    }
    return hn::LoadU(d, lanes[0]);
  }
};

/// Edges as Pluecker lines [Platis2003]: the sign of the permuted inner product with the ray, the
/// corners taken relative to its origin.
template <class Number>
struct Pluecker {
  using Real = Number;
  using State = RayNumbers<Number>;

  static State prepare(const Ray& ray) { return numbers_of<Number>(ray); }

  static HWY_INLINE std::uint32_t meet(const LeafBlock& block, const State& ray, Number* t) {
    const hn::CappedTag<Number, kLanes> d;
    std::uint32_t met = 0;
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
      const auto origin = set3(d, ray.origin);
      const auto direction = set3(d, ray.direction);
      const BlockCorners corners(d, block, i);
      const auto v0 = minus(corners.at[0], origin);
      const auto v1 = minus(corners.at[1], origin);
      const auto v2 = minus(corners.at[2], origin);
      const auto e0 = minus(v2, v0), e1 = minus(v0, v1), e2 = minus(v1, v2);
      const auto u = dot(cross(e0, plus(v2, v0)), direction);
      const auto v = dot(cross(e1, plus(v0, v1)), direction);
      const auto w = dot(cross(e2, plus(v1, v2)), direction);
      const auto least = hn::Min(u, hn::Min(v, w));
      const auto most = hn::Max(u, hn::Max(v, w));
      const auto normal = cross(e0, e1);
      const auto slope = dot(normal, direction);
      hn::StoreU(hn::Div(dot(v0, normal), slope), d, t + i);
      const auto zero = hn::Zero(d);
      const auto in =
          hn::AndNot(hn::Eq(slope, zero), hn::Or(hn::Ge(least, zero), hn::Le(most, zero)));
      met |= bits_of(d, in, i);
    }
    return met;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::contestants
HWY_AFTER_NAMESPACE();

#endif
