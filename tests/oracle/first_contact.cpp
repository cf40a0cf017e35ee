#include "tests/oracle/first_contact.h"

#include <array>
#include <vector>

#include "tests/oracle/hull_distance.h"

namespace sightline::oracle {
namespace {

/// a u + b v + c t <= d
struct Plane {
  std::array<mpq_class, 3> factor;
  mpq_class most;
};

mpq_class determinant(const std::array<std::array<mpq_class, 3>, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

}  // namespace

std::optional<mpq_class> box_contact(const Ray& ray, const Vec3d& half, const Triangle& triangle) {
  return box_contact(ray, half, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, triangle);
}

std::optional<mpq_class> box_contact(const Ray& ray, const Vec3d& half,
                                     const std::array<Vec3d, 3>& axes, const Triangle& triangle) {
  std::vector<Plane> planes{{{-1, 0, 0}, 0},
                            {{0, -1, 0}, 0},
                            {{1, 1, 0}, 1},
                            {{0, 0, -1}, -mpq_class(ray.tmin)},
                            {{0, 0, 1}, mpq_class(ray.tmax)}};
  for (int k = 0; k < 3; ++k) {
    const Vec3d& axis = axes[static_cast<std::size_t>(k)];
    const auto along = [&](const Vec3d& p) -> mpq_class {
      return mpq_class(axis.x) * mpq_class(p.x) + mpq_class(axis.y) * mpq_class(p.y) +
             mpq_class(axis.z) * mpq_class(p.z);
    };
    const mpq_class from = along(triangle.v0);
    const std::array<mpq_class, 3> factor{along(triangle.v1) - from, along(triangle.v2) - from,
                                          -along(ray.direction)};
    const mpq_class offset = along(ray.origin) - from;
    planes.push_back({factor, mpq_class(half[k]) + offset});
    planes.push_back({{-factor[0], -factor[1], -factor[2]}, mpq_class(half[k]) - offset});
  }
  std::optional<mpq_class> least;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = i + 1; j < planes.size(); ++j) {
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        const std::array<const Plane*, 3> chosen{&planes[i], &planes[j], &planes[k]};
        std::array<std::array<mpq_class, 3>, 3> rows;
        for (std::size_t r = 0; r < 3; ++r) rows[r] = chosen[r]->factor;
        const mpq_class all = determinant(rows);
        if (all == 0) continue;
        std::array<mpq_class, 3> x;
        for (std::size_t c = 0; c < 3; ++c) {
          auto replaced = rows;
          for (std::size_t r = 0; r < 3; ++r) replaced[r][c] = chosen[r]->most;
          x[c] = determinant(replaced) / all;
        }
        if (least && x[2] >= *least) continue;
        bool inside = true;
        for (const Plane& p : planes) {
          inside = inside && p.factor[0] * x[0] + p.factor[1] * x[1] + p.factor[2] * x[2] <= p.most;
        }
        if (inside) least = x[2];
      }
    }
  }
  return least;
}

bool capsule_meets(const Ray& ray, const Vec3d& end, const mpq_class& from, const mpq_class& to,
                   const mpq_class& radius, const Triangle& triangle) {
  std::vector<ExactPoint> way;
  for (const Vec3d* begin : {&ray.origin, &end}) {
    for (const mpq_class* t : {&from, &to}) {
      ExactPoint& point = way.emplace_back();
      for (int k = 0; k < 3; ++k) {
        point[static_cast<std::size_t>(k)] =
            mpq_class((*begin)[k]) + *t * mpq_class(ray.direction[k]);
      }
    }
  }
  if (end == ray.origin) way.resize(2);
  return hull_square_distance(way, {exact_point(triangle.v0), exact_point(triangle.v1),
                                    exact_point(triangle.v2)}) <= radius * radius;
}

bool sphere_meets(const Ray& ray, const mpq_class& from, const mpq_class& to,
                  const mpq_class& radius, const Triangle& triangle) {
  return capsule_meets(ray, ray.origin, from, to, radius, triangle);
}

}  // namespace sightline::oracle
