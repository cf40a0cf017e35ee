#include "tests/oracle/brute_force.h"

#include <algorithm>
#include <cmath>

namespace sightline::oracle {
namespace {

struct Q3 {
  mpq_class x, y, z;
  explicit Q3(const Vec3d& v) : x(v.x), y(v.y), z(v.z) {}
  Q3(const mpq_class& a, const mpq_class& b, const mpq_class& c) : x(a), y(b), z(c) {}
};
Q3 operator-(const Q3& a, const Q3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Q3 operator^(const Q3& a, const Q3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
mpq_class operator*(const Q3& a, const Q3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

bool within(const mpq_class& t, const Ray& ray) {
  const bool above = std::isinf(ray.tmin) ? ray.tmin < 0 : t >= mpq_class(ray.tmin);
  const bool below = std::isinf(ray.tmax) ? ray.tmax > 0 : t <= mpq_class(ray.tmax);
  return above && below;
}

}  // namespace

std::optional<mpq_class> brute_least_t(const Ray& ray, const Triangle& triangle) {
  const Q3 o(ray.origin), d(ray.direction);
  const Q3 v[3] = {Q3(triangle.v0), Q3(triangle.v1), Q3(triangle.v2)};
  const Q3 normal = (v[1] - v[0]) ^ (v[2] - v[0]);
  if (normal * normal == 0) return std::nullopt;
  const auto at = [&](const mpq_class& t) {
    return Q3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
  };
  const auto inside = [&](const Q3& p) {
    for (int i = 0; i < 3; ++i) {
      if (((v[(i + 1) % 3] - v[i]) ^ (p - v[i])) * normal < 0) return false;
    }
    return true;
  };

  const mpq_class slope = d * normal;
  const mpq_class height = (v[0] - o) * normal;
  if (slope != 0) {
    const mpq_class t = height / slope;
    if (!within(t, ray) || !inside(at(t))) return std::nullopt;
    return t;
  }
  if (height != 0) return std::nullopt;

  std::optional<mpq_class> least;
  const auto offer = [&](const mpq_class& t) {
    if (within(t, ray) && (!least || t < *least)) least = t;
  };
  if (!std::isinf(ray.tmin) && inside(at(mpq_class(ray.tmin)))) offer(mpq_class(ray.tmin));
  for (int i = 0; i < 3; ++i) {
    const Q3 edge = v[(i + 1) % 3] - v[i];
    const Q3 c = d ^ edge;
    const mpq_class square = c * c;
    if (square == 0) continue;  // along this edge: the ends belong to the other two
    const mpq_class s = (((v[i] - o) ^ d) * c) / square;
    if (s >= 0 && s <= 1) offer((((v[i] - o) ^ edge) * c) / square);
  }
  return least;
}

std::vector<BruteHit> brute_all(const Ray& ray, std::span<const Triangle> triangles) {
  std::vector<BruteHit> hits;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!is_finite(triangles[i])) continue;
    if (const auto t = brute_least_t(ray, triangles[i])) hits.push_back({i, *t});
  }
  std::sort(hits.begin(), hits.end(), [](const BruteHit& a, const BruteHit& b) {
    return a.t != b.t ? a.t < b.t : a.triangle < b.triangle;
  });
  return hits;
}

}  // namespace sightline::oracle
