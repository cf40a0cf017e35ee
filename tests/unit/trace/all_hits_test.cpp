// The first hits of a ray, and how many there are, against a sort of everything by exact t and id.

#include "core/trace/kernel/all_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/infinity.h"
#include "core/trace/kernel/kernel.h"
#include "tests/oracle/random.h"
#include "tests/support/random_cases.h"

namespace sightline {
namespace {

using oracle::Random;

std::shared_ptr<const Scene> scene_of(const std::vector<Vec3f>& corners) {
  auto mesh = std::make_shared<Mesh>();
  for (const Vec3f& corner : corners) {
    mesh->indices.own().push_back(static_cast<std::uint32_t>(mesh->positions.size()));
    mesh->positions.own().push_back(corner);
  }
  mesh->primitives.push_back({0, static_cast<std::uint32_t>(corners.size() / 3), 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({});
  auto scene = Scene::build(std::move(description));
  EXPECT_TRUE(scene.ok());
  return *scene;
}

/// Triangles around the origin, which is a corner of all of them.
std::vector<Vec3f> fan(int count) {
  std::vector<Vec3f> corners;
  const auto rim = [&](int i) {
    const double angle = 6.283185307179586 * i / count;
    return Vec3f{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                 static_cast<float>(0.3 * std::sin(7 * angle))};
  };
  for (int i = 0; i < count; ++i) corners.insert(corners.end(), {{0, 0, 0}, rim(i), rim(i + 1)});
  return corners;
}

/// The same triangle so many times; every other time a little nearer, and some times far.
std::vector<Vec3f> pile(int count, float step) {
  std::vector<Vec3f> corners;
  for (int i = 0; i < count; ++i) {
    const float z = step * static_cast<float>(i % 2) + (i % 5 == 4 ? -3.0f : 0.0f);
    corners.insert(corners.end(), {{-1, -1, 0.1f + z}, {2, -1, 0.3f + z}, {-1, 2, 0.7f + z}});
  }
  return corners;
}

/// Squares of two triangles in one plane.
std::vector<Vec3f> ground(int side) {
  std::vector<Vec3f> corners;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto at = [](int i, int j) {
        return Vec3f{static_cast<float>(i), 0, static_cast<float>(j)};
      };
      corners.insert(corners.end(), {at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y),
                                     at(x, y + 1), at(x + 1, y + 1)});
    }
  }
  return corners;
}

/// Triangles anywhere; on a grid so coarse that many share corners and planes.
std::vector<Vec3f> soup(int count, bool grid, Random& random) {
  std::vector<Vec3f> corners;
  const auto coordinate = [&] {
    return static_cast<float>(grid ? random.integer(-2, 2) : random.between(-2, 2));
  };
  for (int i = 0; i < 3 * count; ++i) {
    const float x = coordinate(), y = coordinate();
    corners.push_back({x, y, coordinate()});
  }
  return corners;
}

struct Truth {
  std::vector<TriangleId> ids;
  std::vector<double> t;
  std::uint64_t once = 0;
};

Truth truth_of(const Scene& scene, std::uint32_t triangles, const Ray& ray) {
  std::vector<std::pair<ExactT, TriangleId>> met;
  Truth truth;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const WorldTriangle triangle = scene.world_triangle({0, i});
    ExactT t;
    if (!exact_hit(ray.origin, ray.direction, ray.tmin, ray.tmax, triangle, t)) continue;
    met.emplace_back(t, TriangleId{0, i});
    truth.once += exact_crossing(ray.origin, ray.direction, triangle) ? 1u : 0u;
  }
  std::vector<std::size_t> order(met.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return compare(met[a].first, met[b].first) < 0;
  });
  for (const std::size_t i : order) {
    truth.ids.push_back(met[i].second);
    truth.t.push_back(met[i].first.rounded());
  }
  return truth;
}

/// Compares every limit with the truth. Returns how many triangles the ray meets.
std::size_t expect_true(const char* name, const Scene& scene, std::uint32_t triangles,
                        const Ray& ray) {
  const Truth truth = truth_of(scene, triangles, ray);
  RayBatch rays;
  rays.push_back(ray);
  for (const Kernel& kernel : supported_kernels()) {
    TraceCounts counts;
    std::uint64_t total = 0, once = 0;
    kernel.all(scene, rays, 0, 1, {Crossings::kEvery, 0, &total, nullptr}, counts);
    kernel.all(scene, rays, 0, 1, {Crossings::kOnce, 0, &once, nullptr}, counts);
    EXPECT_EQ(total, truth.ids.size()) << name << ", " << kernel.name;
    EXPECT_EQ(once, truth.once) << name << ", " << kernel.name;
    for (const std::size_t limit : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{7},
                                    std::size_t{40}, std::size_t{333}, ~std::size_t{0}}) {
      HitBatch hits;
      kernel.all(scene, rays, 0, 1, {Crossings::kEvery, limit, &total, &hits}, counts);
      EXPECT_EQ(total, truth.ids.size()) << name << ", " << kernel.name << ", limit " << limit;
      EXPECT_EQ(hits.size(), std::min(limit, truth.ids.size())) << name << ", limit " << limit;
      for (std::size_t i = 0; i < std::min(hits.size(), truth.ids.size()); ++i) {
        EXPECT_EQ(hits.id(i), truth.ids[i]) << name << ", limit " << limit << ", hit " << i;
        EXPECT_EQ(hits.t[i], truth.t[i]) << name << ", limit " << limit << ", hit " << i;
        if (testing::Test::HasFailure()) return truth.ids.size();
      }
      kernel.all(scene, rays, 0, 1, {Crossings::kOnce, limit, &once, &hits}, counts);
      EXPECT_EQ(once, truth.once) << name << ", " << kernel.name << ", limit " << limit;
    }
    EXPECT_FALSE(counts.stopped);
  }
  return truth.ids.size();
}

TEST(AllHits, are_the_first_of_everything_sorted_by_exact_t_and_id) {
  constexpr std::uint64_t kSeed = 11;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  Random random(kSeed);
  struct Case {
    const char* name;
    std::vector<Vec3f> corners;
    std::vector<Ray> rays;
    std::size_t least;  ///< triangles that some ray meets
  };
  const Vec3d down{-0.1, -0.2, -5}, far{-1e15, -2e15, -5e16};
  // From far away all intervals overlap, and rounded t are equal.
  std::vector<Case> cases{
      {"fan",
       fan(700),
       {{{0.1, 0.2, 5}, down}, {{0.1, 0.2, 5}, down, 1, 1}, {{0, 0, 0}, down}},
       700},
      {"pile", pile(500, 0), {{{0.1, 0.2, 5}, {-0.01, -0.02, -5}}, {{0, 0, -9}, {0, 0, 1}}}, 500},
      {"pile of two heights",
       pile(500, 0x1p-23f),
       {{{0.1, 0.2, 5}, {-0.01, -0.02, -5}}, {{1e15, 2e15, 5e16}, far}, {{1e3, 2e3, 5e4}, far}},
       500},
      {"ground",
       ground(60),
       {{{-1, 0, -1.25}, {1, 0, 1}},
        {{-1, 0, -1}, {1, 0, 1}},
        {{-1, 0, 0}, {1, 0, 0}},
        {{70, 0, 61}, {-7, 0, -6}},
        {{30.5, 0, 30.25}, {0.3, 0, -0.1}, -kInf}},
       200}};
  for (const bool grid : {false, true}) {
    Case c{grid ? "soup on a grid" : "soup", soup(2000, grid, random), {}, 60};
    for (int i = test::random_cases<int>(40); i-- > 0;) {
      const double away = i % 4 == 0 ? 1e14 : 1;
      Ray ray{random.point(-4, 4), {}, -kInf};
      if (grid) ray.origin = {std::round(ray.origin.x), std::round(ray.origin.y), 5};
      ray.direction = {-ray.origin.x, -ray.origin.y, -ray.origin.z};
      ray.origin = {ray.origin.x * away, ray.origin.y * away, ray.origin.z * away};
      c.rays.push_back(ray);
    }
    cases.push_back(c);
  }
  for (const Case& c : cases) {
    const auto scene = scene_of(c.corners);
    std::size_t most = 0;
    for (const Ray& ray : c.rays) {
      most = std::max(
          most, expect_true(c.name, *scene, static_cast<std::uint32_t>(c.corners.size() / 3), ray));
      ASSERT_FALSE(HasFailure()) << c.name;
    }
    EXPECT_GE(most, c.least) << c.name;
    std::printf("%s: up to %zu triangles\n", c.name, most);
  }
}

TEST(AllHits, notice_a_deadline_in_the_middle_of_sorting) {
  const auto scene = scene_of(pile(3, 0));
  RayBatch rays;
  rays.push_back({{0.1, 0.2, 5}, {-0.01, -0.02, -5}});
  CancelFlag over;
  const Deadline deadline{.flag = &over};
  for (const bool is_over : {false, true}) {
    TraceCounts counts{&deadline};
    const RayQuestion question{*scene, rays, 0, counts.decisions};
    AllHits all(question, Crossings::kEvery, 5000, counts);
    for (int i = 0; i < 10000; ++i) all.accept({0, 0}, {0, 1});
    if (is_over) over.cancel();
    HitBatch hits;
    all.append_sorted(hits);
    EXPECT_EQ(counts.stopped, is_over);
    EXPECT_EQ(hits.size(), is_over ? 0 : 5000);
    // Not even the first of many comparisons are made for nobody.
    EXPECT_EQ(counts.decisions.exact_hits < 200, is_over) << counts.decisions.exact_hits;
  }
}

}  // namespace
}  // namespace sightline
