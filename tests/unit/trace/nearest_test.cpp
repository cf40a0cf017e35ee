// Nearest triangles of awkward scenes: the same ids in the same order as rational arithmetic finds
// one by one.

#include "core/trace/search/nearest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/infinity.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/world_triangles.h"
#include "tests/unit/trace/awkward_scenes.h"

namespace sightline {
namespace {

using oracle::Random;

struct Near {
  mpq_class square;
  TriangleId id;
};

/// All of them, by distance and id.
std::vector<Near> by_distance(const oracle::WorldTriangles& world, const Vec3d& point) {
  std::vector<Near> all;
  for (std::size_t i = 0; i < world.triangles.size(); ++i) {
    const oracle::Triangle& t = world.triangles[i];
    if (!oracle::is_finite(t) || oracle::has_no_area(t)) continue;
    all.push_back({oracle::nearest(point, t).square, world.id(i)});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Near& a, const Near& b) { return a.square < b.square; });
  return all;
}

Vec3d some_point(const test::Case& c, const Scene& scene, Random& random) {
  for (;;) {
    const auto w = scene.world_triangle(
        {static_cast<std::uint32_t>(random.index(scene.description().instances.size())),
         static_cast<std::uint32_t>(random.index(test::kTriangles))});
    Vec3d point = w.v0;
    const double reach = static_cast<double>(c.scale) * std::exp2(random.integer(-6, 6));
    for (int k = 0; k < 3; ++k) {
      // On a corner, on the grid beside it, or anywhere near.
      if (random.chance(0.2)) continue;
      point[k] += c.grid ? static_cast<double>(c.scale) * random.integer(-2, 2)
                         : reach * random.between(-1, 1);
    }
    if (is_finite(point)) return point;
  }
}

TEST(NearestTriangles, are_those_of_rational_arithmetic_in_its_order) {
  constexpr std::uint64_t kSeed = 83;
  for (const test::Case& c : test::cases()) {
    Random random(kSeed);
    const auto scene = test::make_scene(c, random);
    const oracle::WorldTriangles world(*scene);
    const Deadline deadline = Deadline::never();
    NearestTriangles nearest(*scene, nullptr, deadline);
    std::size_t ties = 0;
    for (int round = 0; round < 8; ++round) {
      const Vec3d point = some_point(c, *scene, random);
      const std::vector<Near> all = by_distance(world, point);
      for (const std::size_t count : {std::size_t{1}, std::size_t{7}, all.size() + 3}) {
        nearest.find(point, kInf, count);
        ASSERT_EQ(nearest.found().size(), std::min(count, all.size())) << c.name;
        for (std::size_t i = 0; i < nearest.found().size(); ++i) {
          ASSERT_EQ(nearest.found()[i].id, all[i].id) << c.name << " seed " << kSeed << " round "
                                                      << round << " of " << count << " at " << i;
        }
      }
      HitBatch hits;
      hits.resize(2);
      nearest.find(point, kInf, 2);
      nearest.write(0, hits);
      for (std::size_t i = 0; i < 2; ++i)
        ASSERT_TRUE(oracle::is_rounded_root(hits.t[i], all[i].square)) << c.name;
      ties += all[0].square == all[1].square ? 1u : 0u;
      // A distance that ends exactly at one of them, or just before.
      const double limit = hits.t[1];
      for (const double most : {limit, std::nextafter(limit, 0.0)}) {
        nearest.find(point, most, all.size());
        const mpq_class square = mpq_class(most) * mpq_class(most);
        const auto within = std::count_if(all.begin(), all.end(),
                                          [&](const Near& near) { return near.square <= square; });
        ASSERT_EQ(nearest.found().size(), static_cast<std::size_t>(within)) << c.name;
      }
    }
    std::printf("%s: equal distances %zu\n", c.name, ties);
  }
}

TEST(NearestTriangles, visits_little_of_a_large_scene) {
  Random random(84);
  auto mesh = std::make_shared<Mesh>();
  constexpr std::uint32_t kCount = 30000;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const Vec3d p = random.point(-100, 100);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      const Vec3d d = random.point(-0.5, 0.5);
      mesh->positions.own().push_back({static_cast<float>(p.x + d.x), static_cast<float>(p.y + d.y),
                                       static_cast<float>(p.z + d.z)});
      mesh->indices.own().push_back(3 * i + corner);
    }
  }
  mesh->primitives.push_back({0, kCount, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({});
  const auto scene = *Scene::build(std::move(description));
  const Deadline deadline = Deadline::never();
  NearestTriangles nearest(*scene, nullptr, deadline);
  for (int i = 0; i < 100; ++i) nearest.find(random.point(-100, 100), kInf, 1);
  EXPECT_LT(nearest.counts().nodes, 100 * 60u);
  EXPECT_LT(nearest.counts().blocks, 100 * 60u);
  EXPECT_LT(nearest.counts().decisions.exact_compares, 10u);
}

TEST(NearestTriangles, stops_when_the_deadline_passes) {
  Random random(58);
  const auto scene = test::make_scene(test::cases()[4], random);
  CancelFlag flag;
  flag.cancel();
  const Deadline deadline = Deadline::in(std::chrono::hours(1), &flag);
  NearestTriangles nearest(*scene, nullptr, deadline);
  for (int i = 0; i < 100 && !nearest.stopped(); ++i) nearest.find({0, 0, 0}, kInf, 1000);
  EXPECT_TRUE(nearest.stopped());
}

}  // namespace
}  // namespace sightline
