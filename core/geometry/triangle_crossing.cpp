#include "core/geometry/triangle_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/float64_vector.h"
#include "core/geometry/rounding.h"

namespace sightline {
namespace {

using Corner3 = std::array<Vec3d, 3>;

/// Corners in cyclic order, the first of which is alone on its side of the other plane.
struct Turned {
  Corner3 corner;
  int side = 0;  ///< of the first corner
};

Turned turned(const Triangle& t, const std::array<int, 3>& side) {
  const Corner3 corner{t.v0, t.v1, t.v2};
  std::size_t i = 0;
  for (; i < 2; ++i) {
    const int one = side[(i + 1) % 3], other = side[(i + 2) % 3];
    if ((side[i] > 0 && one <= 0 && other <= 0) || (side[i] < 0 && one >= 0 && other >= 0)) break;
  }
  return {{corner[i], corner[(i + 1) % 3], corner[(i + 2) % 3]}, side[i]};
}

std::array<int, 3> sides_of(const Triangle& t, const Triangle& plane) {
  const auto side = [&](const Vec3d& p) { return volume_sign(plane.v0, plane.v1, plane.v2, p); };
  return {side(t.v0), side(t.v1), side(t.v2)};
}

bool are_on_both(const std::array<int, 3>& sides) {
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  return *least < 0 && *most > 0;
}

/// The corners b, c and d as a sees them, by float64 arithmetic.
struct Differences {
  float64::Numbers ab, ac, ad;
  double size;  ///< the largest magnitude of a component

  Differences(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d)
      : ab(float64::minus(b, a)),
        ac(float64::minus(c, a)),
        ad(float64::minus(d, a)),
        size(std::max({float64::largest(ab), float64::largest(ac), float64::largest(ad)})) {}

  void scale(double by) {
    for (auto* vector : {&ab, &ac, &ad}) {
      for (double& x : *vector) x *= by;
    }
    size *= by;
  }

  /// Precondition: size is below 2^300.
  VolumeEstimate volume() const {
    double volume = 0, permanent = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double p = ac[i] * ad[j], q = ac[j] * ad[i];
      volume += ab[k] * (p - q);
      permanent += std::fabs(ab[k]) * (std::fabs(p) + std::fabs(q));
    }
    // 8 units cover the 7 + 56u of [Shewchuk1997]; the second term covers underflow of factors that
    // are below 2^300.
    return {volume, 8 * 0x1p-53 * permanent + 0x1p-770};
  }
};

}  // namespace

VolumeEstimate estimate_volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Differences of(a, b, c, d);
  return of.size < 0x1p300 ? of.volume() : VolumeEstimate{0, kInfD};
}

Dyadic exact_volume(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return dot(difference(b, a), cross(difference(c, a), difference(d, a)));
}

int volume_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  Differences of(a, b, c, d);
  // What scaling takes from a small factor is at most 2^-1075, and the other two are below 2^300.
  const double lost = of.size < 0x1p300 ? 0 : 0x1p-400;
  if (lost > 0) of.scale(0x1p-724);
  VolumeEstimate volume = of.volume();
  volume.error += lost;
  const int sign = of.size < 0x1p300 ? volume.certain_sign() : 0;
  return sign != 0 ? sign : exact_volume(a, b, c, d).sign();
}

bool triangles_cross(const Triangle& a, const Triangle& b) {
  const auto of_a = sides_of(a, b);
  if (!are_on_both(of_a)) return false;
  const auto of_b = sides_of(b, a);
  if (!are_on_both(of_b)) return false;
  Turned p = turned(a, of_a), q = turned(b, of_b);
  // Each first corner comes to lie on the positive side of the other triangle.
  if (p.side < 0) std::swap(q.corner[1], q.corner[2]);
  if (q.side < 0) std::swap(p.corner[1], p.corner[2]);
  return volume_sign(p.corner[0], p.corner[1], q.corner[0], q.corner[1]) < 0 &&
         volume_sign(p.corner[0], p.corner[2], q.corner[2], q.corner[0]) < 0;
}

}  // namespace sightline
