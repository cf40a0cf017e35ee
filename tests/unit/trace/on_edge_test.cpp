// "on_edge" against rational arithmetic.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "core/trace/decision.h"
#include "tests/oracle/exact_triangle.h"
#include "tests/oracle/random.h"

namespace sightline {
namespace {

constexpr std::uint64_t kEdgeSeed = 61;

std::shared_ptr<const Scene> one_triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {a, b, c};
  mesh->indices = {0, 1, 2};
  mesh->primitives.push_back({0, 1, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({});
  return *Scene::build(std::move(description));
}

TEST(OnEdge, is_what_rational_arithmetic_says) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kEdgeSeed));
  oracle::Random random(kEdgeSeed);
  std::size_t on_edge = 0, inside = 0, in_plane = 0;
  for (int round = 0; round < 20000; ++round) {
    // On a small grid many rays meet edges and corners exactly, or lie in the plane.
    const bool is_grid = random.chance(0.7);
    const auto number = [&] {
      return is_grid ? static_cast<float>(random.integer(-2, 2))
                     : static_cast<float>(random.between(-2, 2));
    };
    const Vec3f a{number(), number(), number()}, b{number(), number(), number()},
        c{number(), number(), number()};
    Ray ray;
    ray.origin = {number(), number(), number()};
    ray.direction = {number(), number(), number()};
    if (random.chance(0.3)) {
      ray.origin.z = ray.direction.z = 0;
      ray.tmin = -2;
    }
    RayBatch rays;
    rays.push_back(ray);
    RayFault fault;
    const oracle::Triangle triangle{{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}};
    if (!check_rays(rays, fault) || oracle::has_no_area(triangle)) continue;
    const auto t = oracle::least_t(ray, triangle);
    if (!t) continue;
    const oracle::ExactDetail truth = oracle::exact_detail(ray, triangle, *t);
    const bool expected = truth.u == 0 || truth.v == 0 || truth.u + truth.v == 1;
    const auto scene = one_triangle(a, b, c);
    const HitDetail detail = hit_detail(*scene, ray, {0, 0});
    ASSERT_EQ(hit_on_edge(*scene, ray, {0, 0}, detail), expected) << "round " << round;
    (expected ? on_edge : inside) += 1;
    const Vec3d& d = ray.direction;
    in_plane +=
        truth.normal[0] * d.x + truth.normal[1] * d.y + truth.normal[2] * d.z == 0 ? 1u : 0u;
  }
  std::printf("on an edge %zu, inside %zu, in the plane %zu\n", on_edge, inside, in_plane);
  EXPECT_GT(on_edge, 500u);
  EXPECT_GT(inside, 500u);
  EXPECT_GT(in_plane, 50u);
}

TEST(OnEdge, knows_an_edge_from_its_neighbour_by_one_unit_in_the_last_place) {
  const auto scene = one_triangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const auto asked = [&](double x, double y) {
    const Ray ray{{x, y, 1}, {0, 0, -1}};
    return hit_on_edge(*scene, ray, {0, 0}, hit_detail(*scene, ray, {0, 0}));
  };
  EXPECT_TRUE(asked(1, 3));
  EXPECT_FALSE(asked(1, std::nextafter(3.0, 0.0)));
  EXPECT_TRUE(asked(1, 0));
  EXPECT_FALSE(asked(1, 1e-300));
  EXPECT_TRUE(asked(0, 0));
}

}  // namespace
}  // namespace sightline
