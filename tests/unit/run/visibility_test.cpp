// What stands between points, against rational arithmetic.

#include "core/run/engine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/oracle/random.h"
#include "tests/oracle/scene_oracle.h"
#include "tests/oracle/world_triangles.h"

namespace sightline {
namespace {

constexpr std::uint64_t kVisibilitySeed = 64;

TEST(Visibility, is_what_rational_arithmetic_sees) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kVisibilitySeed));
  oracle::Random random(kVisibilitySeed);
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < 60; ++i) {
    const auto x = [&] { return static_cast<float>(random.integer(-4, 4)); };
    mesh->positions.own().push_back({x(), x(), x()});
  }
  for (std::uint32_t i = 0; i < 60; ++i) mesh->indices.own().push_back(i);
  mesh->primitives.push_back({0, 20, 0, kNone});
  SceneDescription description;
  description.meshes = {mesh};
  description.nodes.push_back({});
  description.instances.push_back({});
  const auto scene = *Scene::build(std::move(description));
  const oracle::WorldTriangles world(*scene);
  const oracle::SceneOracle oracle(world.triangles);
  const auto engine = *Engine::create({2, ""});

  std::size_t seen = 0, ends_differ = 0;
  for (const BoxPairing pairing : {BoxPairing::kAll, BoxPairing::kEach}) {
    // On a grid differences are exact, ends lie on triangles, and points coincide.
    PointPairs pairs;
    pairs.pairing = pairing;
    const std::size_t count = pairing == BoxPairing::kAll ? 50 : 2000;
    for (std::size_t i = 0; i < count; ++i) {
      for (Column<Vec3d>* points : {&pairs.from, &pairs.to}) {
        const double step = random.chance(0.8) ? 1 : 0.125;
        const auto x = [&] { return random.integer(-5, 5) * step; };
        points->push_back({x(), x(), x()});
      }
    }
    Column<std::uint8_t> visible[2], again;
    for (const bool closed : {false, true}) {
      pairs.closed = closed;
      HitBatch blockers;
      ASSERT_TRUE(engine->visibility(*scene, pairs, Deadline::never(), visible[closed], nullptr));
      ASSERT_TRUE(engine->visibility(*scene, pairs, Deadline::never(), again, &blockers));
      ASSERT_EQ(visible[closed], again);
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Vec3d a = pairs.from[pairing == BoxPairing::kAll ? i / count : i];
        const Vec3d b = pairs.to[pairing == BoxPairing::kAll ? i % count : i];
        Ray line{a, {b.x - a.x, b.y - a.y, b.z - a.z}, 0, 1};
        // Of one point any line through it; a ray in a triangle's plane may leave an end inside it.
        if (a == b) line = {a, {0, 0, 1}, 0, 0};
        if (!closed) {
          line.tmin = std::numeric_limits<double>::denorm_min();
          line.tmax = std::nextafter(1.0, 0.0);
        }
        const bool between = !(a == b && !closed) && oracle.any(line);
        ASSERT_EQ(visible[closed][i] != 0, !between) << i << " closed " << closed;
        ASSERT_EQ(blockers.hit(i), between);
        seen += visible[closed][i];
      }
    }
    for (std::size_t i = 0; i < pairs.size(); ++i)
      ends_differ += visible[0][i] != visible[1][i] ? 1u : 0u;
  }
  std::printf("visible %zu, differ by their ends %zu\n", seen, ends_differ);
  EXPECT_GT(seen, 500u);
  EXPECT_GT(ends_differ, 50u);
}

}  // namespace
}  // namespace sightline
