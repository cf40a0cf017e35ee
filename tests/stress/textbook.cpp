#include "tests/stress/textbook.h"

#include <cmath>

namespace sightline::stress {
namespace {

template <class Real>
Real3<Real> operator-(const Real3<Real>& a, const Real3<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
Real3<Real> cross(const Real3<Real>& a, const Real3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Real dot(const Real3<Real>& a, const Real3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace

template <class Real>
std::optional<Real> moeller_trumbore(const RealRay<Real>& ray, const RealTriangle<Real>& w) {
  const Real3<Real> e1 = w.v1 - w.v0;
  const Real3<Real> e2 = w.v2 - w.v0;
  const Real3<Real> p = cross(ray.direction, e2);
  const Real det = dot(e1, p);
  if (det == 0) return std::nullopt;
  const Real3<Real> s = ray.origin - w.v0;
  const Real u = dot(s, p) / det;
  if (!(u >= 0 && u <= 1)) return std::nullopt;
  const Real3<Real> q = cross(s, e1);
  const Real v = dot(ray.direction, q) / det;
  if (!(v >= 0 && u + v <= 1)) return std::nullopt;
  const Real t = dot(e2, q) / det;
  if (!(t >= ray.tmin && t <= ray.tmax)) return std::nullopt;
  return t;
}

template std::optional<float> moeller_trumbore(const RealRay<float>&, const RealTriangle<float>&);
template std::optional<double> moeller_trumbore(const RealRay<double>&,
                                                const RealTriangle<double>&);

WoopRay::WoopRay(const Ray& source) : ray(source) {
  const Real3<float>& d = ray.direction;
  kz = std::fabs(d.x) > std::fabs(d.y) ? 0 : 1;
  if (std::fabs(d.z) > std::fabs(d[kz])) kz = 2;
  kx = (kz + 1) % 3;
  ky = (kx + 1) % 3;
  if (d[kz] < 0) std::swap(kx, ky);
  sx = d[kx] / d[kz];
  sy = d[ky] / d[kz];
  sz = 1.0F / d[kz];
}

std::optional<float> woop(const WoopRay& r, const RealTriangle<float>& w) {
  const Real3<float> a = w.v0 - r.ray.origin;
  const Real3<float> b = w.v1 - r.ray.origin;
  const Real3<float> c = w.v2 - r.ray.origin;
  const float ax = a[r.kx] - r.sx * a[r.kz], ay = a[r.ky] - r.sy * a[r.kz];
  const float bx = b[r.kx] - r.sx * b[r.kz], by = b[r.ky] - r.sy * b[r.kz];
  const float cx = c[r.kx] - r.sx * c[r.kz], cy = c[r.ky] - r.sy * c[r.kz];
  float u = cx * by - cy * bx;
  float v = ax * cy - ay * cx;
  float q = bx * ay - by * ax;
  if (u == 0 || v == 0 || q == 0) {
    const auto again = [](float p, float s, float g, float h) {
      using D = double;
      return static_cast<float>(D{p} * D{s} - D{g} * D{h});
    };
    u = again(cx, by, cy, bx);
    v = again(ax, cy, ay, cx);
    q = again(bx, ay, by, ax);
  }
  if ((u < 0 || v < 0 || q < 0) && (u > 0 || v > 0 || q > 0)) return std::nullopt;
  const float det = u + v + q;
  if (det == 0) return std::nullopt;
  const float t = (u * (r.sz * a[r.kz]) + v * (r.sz * b[r.kz]) + q * (r.sz * c[r.kz])) / det;
  if (!(t >= r.ray.tmin && t <= r.ray.tmax)) return std::nullopt;
  return t;
}

}  // namespace sightline::stress
