// Two groups of awkward scenes: the pairs that rational arithmetic finds one by one.

#include "core/trace/search/clearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "tests/oracle/exact_triangle.h"
#include "tests/oracle/hull_distance.h"
#include "tests/oracle/nearest_point.h"
#include "tests/oracle/random.h"
#include "tests/oracle/world_triangles.h"
#include "tests/unit/trace/awkward_scenes.h"

namespace sightline {
namespace {

using oracle::ExactPoint;

struct ExactPair {
  mpq_class square;
  TriangleId a, b;
};

/// Those of one instance, or of all others.
ResolvedFilter sides_of(const Scene& scene, std::uint32_t instance, bool others) {
  ResolvedFilter resolved;
  const auto& description = scene.description();
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    resolved.first.push_back(resolved.sides.size());
    const auto& mesh = *description.meshes[description.instances[i].mesh];
    resolved.sides.insert(resolved.sides.end(), mesh.primitives.size(),
                          (i == instance) != others ? ResolvedFilter::kAll : std::uint8_t{0});
  }
  return resolved;
}

/// By distance and ids.
std::vector<ExactPair> all_pairs(const TriangleGroup& a, const TriangleGroup& b) {
  std::vector<ExactPair> pairs;
  const auto corners = [](const Triangle& t) {
    return std::vector<ExactPoint>{oracle::exact_point(t.v0), oracle::exact_point(t.v1),
                                   oracle::exact_point(t.v2)};
  };
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j) {
      pairs.push_back({oracle::hull_square_distance(corners(a.triangle(i)), corners(b.triangle(j))),
                       a.id(i), b.id(j)});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const ExactPair& x, const ExactPair& y) {
    if (x.square != y.square) return x.square < y.square;
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  return pairs;
}

/// Two meshes of some triangles each, on a grid or not, beside or within each other.
std::shared_ptr<const Scene> two_meshes(oracle::Random& random, std::uint32_t count) {
  SceneDescription description;
  const bool is_grid = random.chance(0.5);
  const double scale = std::ldexp(1.0, random.chance(0.3) ? random.integer(-60, 60) : 0);
  const double apart = random.chance(0.5) ? 9 : 2;
  for (int m = 0; m < 2; ++m) {
    auto mesh = std::make_shared<Mesh>();
    for (std::uint32_t i = 0; i < 3 * count; ++i) {
      const auto x = [&] {
        return static_cast<float>((is_grid ? random.integer(-4, 4) : random.between(-4, 4)) *
                                  scale);
      };
      Vec3f p{x(), x(), x()};
      p.x += static_cast<float>(m * apart * scale);
      mesh->positions.own().push_back(p);
      mesh->indices.own().push_back(i);
    }
    mesh->primitives.push_back({0, count, 0, 0xffffffffu});
    description.meshes.push_back(mesh);
    description.nodes.push_back({});
    Instance instance;
    instance.mesh = instance.node = static_cast<std::uint32_t>(m);
    description.instances.push_back(instance);
  }
  return *Scene::build(std::move(description));
}

TEST(Clearance, finds_the_pairs_of_rational_arithmetic) {
  constexpr std::uint64_t kSeed = 191;
  std::printf("seed %llu\n", static_cast<unsigned long long>(kSeed));
  oracle::Random random(kSeed);
  std::size_t met = 0, ties = 0, pairs = 0;
  const Deadline never = Deadline::never();
  for (int round = 0; round < 40; ++round) {
    const auto scene = two_meshes(random, 9);
    const TriangleGroup a(*scene, sides_of(*scene, 0, false), never),
        b(*scene, sides_of(*scene, 0, true), never);
    const std::vector<ExactPair> expected = all_pairs(a, b);
    pairs += expected.size();
    Clearance search(*scene, a, b, never);
    search.find({}, 1u << 20);
    ClearanceAnswer answer;
    search.write(10, answer);
    ASSERT_EQ(answer.pairs.size(), 1u);
    const ClearancePair& closest = answer.pairs[0];
    ASSERT_EQ(closest.a, expected[0].a) << "round " << round;
    ASSERT_EQ(closest.b, expected[0].b) << "round " << round;
    ASSERT_TRUE(oracle::is_rounded_root(closest.distance, expected[0].square));
    met += expected[0].square == 0 ? 1u : 0u;
    ties += expected[0].square == expected[1].square ? 1u : 0u;

    // All within a distance that ends at one of them, or just before.
    const mpq_class& square = expected[expected.size() / 4].square;
    double limit = std::sqrt(square.get_d());
    if (mpq_class(limit) * mpq_class(limit) < square) limit = std::nextafter(limit, 1e300);
    for (const double distance : {limit, std::nextafter(limit, 0.0)}) {
      std::set<std::pair<TriangleId, TriangleId>> within;
      for (const ExactPair& pair : expected) {
        if (pair.square <= mpq_class(distance) * mpq_class(distance))
          within.insert({pair.a, pair.b});
      }
      Clearance near(*scene, a, b, never);
      near.find({ClearancePairs::kTriangles, distance, 0}, 1u << 20);
      near.write(1u << 20, answer);
      ASSERT_EQ(answer.total, within.size()) << "round " << round;
      std::set<std::pair<TriangleId, TriangleId>> found;
      for (const ClearancePair& pair : answer.pairs) found.insert({pair.a, pair.b});
      ASSERT_EQ(found, within) << "round " << round;
      Clearance of_nodes(*scene, a, b, never);
      of_nodes.find({ClearancePairs::kNodes, distance, 0}, 1u << 20);
      of_nodes.write(10, answer);
      ASSERT_EQ(answer.total, within.empty() ? 0u : 1u);
      if (!within.empty()) {
        ASSERT_EQ(answer.pairs[0].a, expected[0].a);
        ASSERT_EQ(answer.pairs[0].b, expected[0].b);
      }
    }
  }
  std::printf("%zu pairs of 40 rounds: meet %zu, equally close %zu, wrong 0\n", pairs, met, ties);
  EXPECT_GT(met, 5u);
  EXPECT_GT(ties, 5u);
}

TEST(Clearance, says_when_there_are_too_many_and_when_time_is_over) {
  oracle::Random random(192);
  const auto scene = two_meshes(random, 60);
  const Deadline never = Deadline::never();
  const TriangleGroup all(*scene, sides_of(*scene, 99, true), never);
  Clearance many(*scene, all, all, never);
  many.find({ClearancePairs::kTriangles, 1e300, 0}, 100);
  EXPECT_TRUE(many.too_many());
  CancelFlag flag;
  flag.cancel();
  const Deadline passed = Deadline::in(std::chrono::hours(1), &flag);
  Clearance late(*scene, all, all, passed);
  late.find({ClearancePairs::kTriangles, 1e300, 0}, 1u << 20);
  EXPECT_TRUE(late.stopped());
}

TEST(Clearance, looks_at_little_of_large_groups_that_are_apart) {
  oracle::Random random(193);
  SceneDescription description;
  for (int m = 0; m < 2; ++m) {
    auto mesh = std::make_shared<Mesh>();
    for (std::uint32_t i = 0; i < 20000; ++i) {
      const Vec3d p = random.point(-50, 50);
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        const Vec3d d = random.point(-0.5, 0.5);
        mesh->positions.own().push_back({static_cast<float>(p.x + d.x + 120 * m),
                                         static_cast<float>(p.y + d.y),
                                         static_cast<float>(p.z + d.z)});
        mesh->indices.own().push_back(3 * i + corner);
      }
    }
    mesh->primitives.push_back({0, 20000, 0, 0xffffffffu});
    description.meshes.push_back(mesh);
    description.nodes.push_back({});
    Instance instance;
    instance.mesh = instance.node = static_cast<std::uint32_t>(m);
    description.instances.push_back(instance);
  }
  const auto scene = *Scene::build(std::move(description));
  const Deadline never = Deadline::never();
  const TriangleGroup a(*scene, sides_of(*scene, 0, false), never),
      b(*scene, sides_of(*scene, 0, true), never);
  Clearance search(*scene, a, b, never);
  search.find({}, 1);
  std::printf("%llu pairs of boxes\n", static_cast<unsigned long long>(search.counts().nodes));
  EXPECT_LT(search.counts().nodes, 20000u);
}

}  // namespace
}  // namespace sightline
