#pragma once
/// The tests of the textbooks, written as their authors wrote them, without epsilons.

#include <optional>
#include <utility>

#include "core/query/ray_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::stress {

template <class Real>
struct Real3 {
  Real x = 0, y = 0, z = 0;
  Real3() = default;
  explicit Real3(const Vec3d& v)
      : x(static_cast<Real>(v.x)), y(static_cast<Real>(v.y)), z(static_cast<Real>(v.z)) {}
  Real3(Real a, Real b, Real c) : x(a), y(b), z(c) {}
  Real operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

template <class Real>
struct RealTriangle {
  Real3<Real> v0, v1, v2;
  explicit RealTriangle(const oracle::Triangle& w) : v0(w.v0), v1(w.v1), v2(w.v2) {}
};

template <class Real>
struct RealRay {
  Real3<Real> origin, direction;
  Real tmin, tmax;
  explicit RealRay(const Ray& ray)
      : origin(ray.origin),
        direction(ray.direction),
        tmin(static_cast<Real>(ray.tmin)),
        tmax(static_cast<Real>(ray.tmax)) {}
};

/// [Moeller1997], the form that divides.
template <class Real>
std::optional<Real> moeller_trumbore(const RealRay<Real>& ray, const RealTriangle<Real>& w);

/// What [Woop2013] computes once per ray.
struct WoopRay {
  RealRay<float> ray;
  int kx = 0, ky = 0, kz = 0;
  float sx = 0, sy = 0, sz = 0;
  explicit WoopRay(const Ray& ray);
};

/// [Woop2013], appendix A: float32, the edge functions again in float64 when one of them is zero.
std::optional<float> woop(const WoopRay& ray, const RealTriangle<float>& w);

}  // namespace sightline::stress
