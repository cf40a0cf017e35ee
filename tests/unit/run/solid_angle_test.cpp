// Generalized winding numbers against the sum of the solid angles of all triangles, in numbers of 64
// bits.

#include "core/trace/search/solid_angle.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "core/geometry/exact_hit.h"
#include "core/run/engine.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using Wide = long double;
using WideVector = std::array<Wide, 3>;

WideVector from_to(const Vec3d& p, const Vec3d& v) {
  return {Wide{v.x} - Wide{p.x}, Wide{v.y} - Wide{p.y}, Wide{v.z} - Wide{p.z}};
}
Wide dot(const WideVector& a, const WideVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct Judged {
  Wide value = 0, error = 0;
};

/// All triangles, each by the formula for three corners.
Judged winding(const Scene& scene, const Vec3d& p) {
  Judged sum;
  const auto& description = scene.description();
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    for (std::uint32_t k = 0; k < description.meshes[0]->triangle_count(); ++k) {
      const Triangle t = scene.world_triangle({i, k});
      const WideVector a = from_to(p, t.v0), b = from_to(p, t.v1), c = from_to(p, t.v2);
      const Wide la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
      const Wide up = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                      a[2] * (b[0] * c[1] - b[1] * c[0]);
      const Wide along = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
      // A triangle without an area, or a point in its plane beside it.
      if (up == 0) continue;
      sum.value += std::atan2(up, along) / (2 * 3.14159265358979323846264338327950288L);
      sum.error += 0x1p-57L * la * lb * lc / std::hypot(up, along);
    }
  }
  return sum;
}

/// True if p lies on the line of a triangle without an area, which is not part of the surface: the
/// angle of its edges has no value there.
bool is_on_flat_triangle(const Scene& scene, const Vec3d& p) {
  for (std::uint32_t i = 0; i < scene.description().instances.size(); ++i) {
    for (std::uint32_t k = 0; k < scene.description().meshes[0]->triangle_count(); ++k) {
      const Triangle t = scene.world_triangle({i, k});
      if (!is_degenerate(t)) continue;
      for (const auto& [from, to] : {std::pair{t.v0, t.v1}, {t.v1, t.v2}, {t.v2, t.v0}}) {
        const WideVector a = from_to(p, from), b = from_to(p, to);
        const WideVector turn{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                              a[0] * b[1] - a[1] * b[0]};
        if (dot(turn, turn) <= 0x1p-90L * dot(a, a) * dot(b, b)) return true;
      }
    }
  }
  return false;
}

/// Triangles between few points of a grid, twice placed, once mirrored.
std::shared_ptr<const Scene> random_scene(oracle::Random& random) {
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < 9; ++i) {
    const auto x = [&] { return static_cast<float>(random.integer(-4, 4)); };
    const float a = x(), b = x();
    mesh->positions.own().push_back({a, b, x()});
  }
  for (int i = 0; i < 3 * 12; ++i)
    mesh->indices.own().push_back(static_cast<std::uint32_t>(random.index(9)));
  mesh->primitives.push_back({0, mesh->triangle_count(), 0, kNone});
  SceneDescription description;
  description.meshes = {std::move(mesh)};
  description.nodes.push_back({});
  description.instances.resize(2);
  auto& m = description.instances[1].world_from_mesh.m;
  m[0][0] = -1.5;
  m[1][1] = random.between(0.5, 2);
  m[2][0] = 0.25;
  m[0][3] = 3;
  return *Scene::build(std::move(description));
}

TEST(SolidAngle, of_open_meshes_is_the_sum_over_all_triangles) {
  constexpr std::uint64_t kSeed = 181;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  const auto engine = *Engine::create({1, ""});
  std::size_t judged = 0, through_edges = 0, on_flat = 0;
  double most = 0;
  const int rounds = test::random_cases(20);
  for (int round = 0; round < rounds; ++round) {
    const auto scene = random_scene(random);
    const auto& positions = scene->description().meshes[0]->positions;
    Column<Vec3d> points;
    for (int i = 0; i < 120; ++i) {
      const auto x = [&] { return random.integer(-12, 12) / 2.0; };
      Vec3d p{x(), x(), x()};
      if (random.chance(0.5))
        p = {random.between(-6, 6), random.between(-6, 6), random.between(-6, 6)};
      if (random.chance(0.3)) {
        // The first ray goes through a corner or the middle of an edge, exactly.
        const Vec3f a = positions[random.index(9)], b = positions[random.index(9)];
        const double far = random.integer(1, 8);
        p = {(double{a.x} + double{b.x}) / 2 - far * 0.8125,
             (double{a.y} + double{b.y}) / 2 - far * 0.28125,
             (double{a.z} + double{b.z}) / 2 - far * 0.515625};
        ++through_edges;
      }
      points.push_back(p);
    }
    InsideAnswers answers;
    ASSERT_TRUE(
        engine->inside(*scene, points, InsideMethod::kSolidAngle, Deadline::never(), answers));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (answers.on_surface[i] != 0) {
        ASSERT_TRUE(std::isnan(answers.generalized[i]));
        continue;
      }
      const Judged expected = winding(*scene, points[i]);
      const Wide off = std::fabs(Wide{answers.generalized[i]} - expected.value);
      ASSERT_LE(off, Wide{answers.error[i]} + expected.error)
          << "round " << round << " point " << i;
      if (answers.error[i] > 1e-6) {
        ASSERT_TRUE(is_on_flat_triangle(*scene, points[i])) << "round " << round << " point " << i;
        ++on_flat;
        continue;
      }
      most = std::max(most, answers.error[i]);
      ASSERT_EQ(answers.inside[i] != 0, std::fabs(answers.generalized[i]) > 0.5);
      ++judged;
    }
  }
  std::printf(
      "%zu points, %zu with a ray through an edge or corner, largest bound %g, %zu on a flat "
      "triangle, "
      "wrong 0\n",
      judged, through_edges, most, on_flat);
  EXPECT_GT(judged, test::random_cases(1900u));
}

}  // namespace
}  // namespace sightline
