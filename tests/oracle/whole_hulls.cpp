#include "tests/oracle/whole_hulls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace sightline::oracle {
namespace {

std::vector<Whole> differences(const std::vector<Whole>& a, const std::vector<Whole>& b) {
  std::vector<Whole> all;
  for (const auto* points : {&a, &b}) {
    for (std::size_t i = 0; i < points->size(); ++i) {
      for (std::size_t j = i + 1; j < points->size(); ++j) {
        const Whole d = minus((*points)[j], (*points)[i]);
        if (d != Whole{}) all.push_back(d);
      }
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// How far b reaches beyond the begin of a along an axis, in lengths of the axis: below 0 apart.
long long overlap_along(const Whole& axis, const std::vector<Whole>& a,
                        const std::vector<Whole>& b) {
  long long most_a = std::numeric_limits<long long>::min(), least_b = -(most_a + 1);
  for (const Whole& p : a) most_a = std::max(most_a, dot(axis, p));
  for (const Whole& p : b) least_b = std::min(least_b, dot(axis, p));
  return most_a - least_b;
}

}  // namespace

Whole whole_point(Random& random, int size) {
  const int x = random.integer(-size, size), y = random.integer(-size, size);
  return {x, y, random.integer(-size, size)};
}

Vec3d scaled(const Whole& p, int exponent) {
  return {std::ldexp(static_cast<double>(p[0]), exponent),
          std::ldexp(static_cast<double>(p[1]), exponent),
          std::ldexp(static_cast<double>(p[2]), exponent)};
}

Meeting meeting_of(const std::vector<Whole>& a, const std::vector<Whole>& b) {
  const std::vector<Whole> edges = differences(a, b);
  // Normals of the faces of the difference of both; of a flat one those of its plane and, in it, of
  // its edges; of a straight one its direction.
  std::vector<Whole> axes;
  for (const Whole& e : edges) {
    for (const Whole& f : edges) {
      const Whole n = cross(e, f);
      if (n != Whole{}) axes.push_back(n);
    }
  }
  const bool is_solid = std::any_of(axes.begin(), axes.end(), [&](const Whole& n) {
    return std::any_of(edges.begin(), edges.end(), [&](const Whole& e) { return dot(n, e) != 0; });
  });
  if (!is_solid) {
    const std::vector<Whole> normals = axes;
    for (const Whole& n : normals) {
      for (const Whole& e : edges) axes.push_back(cross(n, e));
    }
    for (const Whole& e : edges) axes.push_back(e);
    for (std::size_t k = 0; k < 3; ++k) {
      Whole unit{};
      unit[k] = 1;
      axes.push_back(unit);
      for (const Whole& e : edges) axes.push_back(cross(unit, e));
    }
  }
  bool do_touch = !is_solid;
  for (const Whole& n : axes) {
    for (const Whole& axis : {n, Whole{-n[0], -n[1], -n[2]}}) {
      const long long overlap = overlap_along(axis, a, b);
      if (overlap < 0) return Meeting::kApart;
      do_touch = do_touch || (overlap == 0 && axis != Whole{});
    }
  }
  return do_touch ? Meeting::kTouch : Meeting::kOverlap;
}

LeastTranslation least_translation(const std::vector<Whole>& points,
                                   const std::array<Whole, 3>& triangle) {
  const std::vector<Whole> b(triangle.begin(), triangle.end());
  const std::vector<Whole> edges = differences(points, b);
  const Whole normal = cross(minus(b[1], b[0]), minus(b[2], b[0]));
  std::vector<Whole> axes{normal, {-normal[0], -normal[1], -normal[2]}};
  for (const Whole& e : edges) {
    for (const Whole& f : edges) {
      if (const Whole n = cross(e, f); n != Whole{}) axes.push_back(n);
    }
  }
  std::optional<LeastTranslation> best;
  __extension__ using Wide = __int128;
  const auto sign = [](Wide x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
  for (std::size_t i = 0; i < axes.size(); ++i) {
    // The end of the triangle beyond the begin of the hull.
    const LeastTranslation next{overlap_along(axes[i], b, points), axes[i]};
    if (!best) {
      best = next;
      continue;
    }
    const Wide square = dot(next.along, next.along), best_square = dot(best->along, best->along);
    const Wide order = Wide{next.overlap} * next.overlap * best_square -
                       Wide{best->overlap} * best->overlap * square;
    if (order > 0) continue;
    if (order == 0) {
      const bool is_of_triangle = best->along == axes[0] || best->along == axes[1];
      if (is_of_triangle) continue;
      int difference = 0;
      for (std::size_t k = 0; k < 3 && difference == 0; ++k) {
        const Wide x = next.along[k], y = best->along[k];
        difference = sign(sign(x) * x * x * best_square - sign(y) * y * y * square);
      }
      if (difference <= 0) continue;
    }
    best = next;
  }
  return *best;
}

}  // namespace sightline::oracle
