#include "tests/oracle/nearest_point.h"

#include <cmath>
#include <limits>

namespace sightline::oracle {
namespace {

using Exact = std::array<mpq_class, 3>;

Exact exact_point(const Vec3d& p) { return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)}; }
Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
mpq_class dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

NearestPoint nearest(const Vec3d& point, const Triangle& triangle) {
  const Exact p = exact_point(point), a = exact_point(triangle.v0);
  const Exact ab = minus(exact_point(triangle.v1), a), ac = minus(exact_point(triangle.v2), a);
  const Exact ap = minus(p, a);
  NearestPoint best;
  bool found = false;
  const auto offer = [&](const mpq_class& u, const mpq_class& v) {
    Exact away, position;
    for (std::size_t k = 0; k < 3; ++k) {
      position[k] = a[k] + u * ab[k] + v * ac[k];
      away[k] = p[k] - position[k];
    }
    const mpq_class square = dot(away, away);
    if (found && square >= best.square) return;
    found = true;
    best.square = square;
    best.position = position;
    best.u = u;
    best.v = v;
  };
  offer(0, 0);
  offer(1, 0);
  offer(0, 1);
  const Exact bc = minus(ac, ab), bp = minus(ap, ab);
  const mpq_class on_ab = dot(ap, ab) / dot(ab, ab), on_ac = dot(ap, ac) / dot(ac, ac),
                  on_bc = dot(bp, bc) / dot(bc, bc);
  if (on_ab > 0 && on_ab < 1) offer(on_ab, 0);
  if (on_ac > 0 && on_ac < 1) offer(0, on_ac);
  if (on_bc > 0 && on_bc < 1) offer(1 - on_bc, on_bc);
  // The foot on the plane: the two weights that leave nothing along ab and ac.
  const mpq_class e = dot(ab, ab), f = dot(ab, ac), g = dot(ac, ac), h = dot(ap, ab),
                  i = dot(ap, ac), determinant = e * g - f * f;
  const mpq_class u = (h * g - i * f) / determinant, v = (i * e - h * f) / determinant;
  if (u > 0 && v > 0 && u + v < 1) offer(u, v);
  best.on_edge = best.u == 0 || best.v == 0 || best.u + best.v == 1;
  const Exact normal{ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                     ab[0] * ac[1] - ab[1] * ac[0]};
  best.front = dot(normal, ap) > 0;
  return best;
}

bool is_rounded_root(double rounded, const mpq_class& square) {
  if (rounded < 0 || std::isnan(rounded)) return false;
  const double most = std::numeric_limits<double>::max();
  const auto middle = [&](double low, double high) -> mpq_class {
    // Beyond the largest number the gap continues.
    if (std::isinf(high)) return mpq_class(low) + (mpq_class(low) - std::nextafter(low, 0.0)) / 2;
    return (mpq_class(low) + mpq_class(high)) / 2;
  };
  if (std::isinf(rounded)) {
    const mpq_class edge = middle(most, rounded);
    return square >= edge * edge;
  }
  const mpq_class above = middle(rounded, std::nextafter(rounded, INFINITY));
  if (square > above * above) return false;
  if (rounded == 0) return true;
  const mpq_class below = middle(std::nextafter(rounded, 0.0), rounded);
  return square >= below * below;
}

}  // namespace sightline::oracle
