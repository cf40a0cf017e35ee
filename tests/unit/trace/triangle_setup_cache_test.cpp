// Rounded t of rays from one point that share planes, whichever planes were met before.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/trace/decision.h"
#include "core/trace/kernel/kernel.h"

namespace sightline {
namespace {

/// A wall of strips from narrower than a ray's way to the next to wider than many packets; each is
/// two triangles with corners at depths of their own. Placed by a matrix that rounds.
std::shared_ptr<const Scene> wall_of_strips(std::mt19937_64& random, const Affine& place) {
  std::uniform_real_distribution<float> any(0, 1);
  auto mesh = std::make_shared<Mesh>();
  float x = -40;
  for (std::uint32_t i = 0; x < 40; ++i) {
    const float width = std::ldexp(0.01f + any(random), static_cast<int>(i / 7 % 12) - 7);
    for (const float corner_x : {x, x + width}) {
      for (const float y : {-4.0f, 4.0f})
        mesh->positions.own().push_back({corner_x, y, 9 + any(random)});
    }
    x += width;
    for (const std::uint32_t corner : {0u, 1u, 2u, 1u, 2u, 3u})
      mesh->indices.own().push_back(4 * i + corner);
  }
  const auto triangles = static_cast<std::uint32_t>(mesh->indices.size() / 3);
  mesh->primitives.push_back({0, triangles, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({0, 0, place});
  auto scene = Scene::build(std::move(description));
  EXPECT_TRUE(scene.ok());
  return *scene;
}

/// Rows along the wall. `eyes` of them take turns, each for `turn` rays.
RayBatch rows_along(std::size_t rows, std::size_t columns, std::size_t eyes, std::size_t turn,
                    std::mt19937_64& random) {
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Vec3d> eye(eyes);
  for (Vec3d& e : eye) e = {any(random), any(random), any(random)};
  RayBatch rays;
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const double x = 20 * (static_cast<double>(i % columns) / static_cast<double>(columns) - 0.4);
    const std::size_t row = i / columns;
    const double y = 3 * (static_cast<double>(row) / static_cast<double>(rows) - 0.6);
    rays.push_back({eye[i / turn % eyes], {x * 1.1, y, 10 + 1e-3 * any(random)}});
  }
  return rays;
}

TEST(TriangleSetupCache, t_is_the_exact_one_rounded_whichever_planes_were_met_before) {
  std::mt19937_64 random(11);
  Affine place;
  place.m[0][0] = 1.1, place.m[1][1] = 0.9, place.m[2][0] = 0.01, place.m[0][3] = 0.3;
  for (const auto& scene : {wall_of_strips(random, Affine{}), wall_of_strips(random, place)}) {
    // One eye; one for each packet, or so; more than one in a packet, or in a group of eight.
    for (const auto& [eyes, turn] :
         {std::pair<std::size_t, std::size_t>{1, 1}, {2, 32}, {3, 8}, {2, 5}}) {
      const RayBatch rays = rows_along(10, 200, eyes, turn, random);
      for (const Kernel& kernel : supported_kernels()) {
        HitBatch hits;
        hits.resize(rays.size());
        TraceCounts counts;
        kernel.closest(*scene, rays, 0, rays.size(), hits, counts);
        HitBatch alone;
        alone.resize(rays.size());
        std::size_t met = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          TraceCounts ignored;
          kernel.closest(*scene, rays, i, i + 1, alone, ignored);
          ASSERT_EQ(hits.id(i), alone.id(i)) << kernel.name << ", " << eyes << " eyes, ray " << i;
          if (!hits.hit(i)) continue;
          ++met;
          ASSERT_EQ(hits.t[i], exact_t(*scene, rays[i], hits.id(i)))
              << kernel.name << ", " << eyes << " eyes, ray " << i;
        }
        EXPECT_GT(met, rays.size() * 3 / 4);
        if (kernel.name.starts_with("avx")) {
          EXPECT_GT(counts.packet_rays, rays.size() / 4);
        }
        // The exact way is for what nobody can tell otherwise, not for every ray.
        EXPECT_LT(counts.decisions.exact_roundings, 3u);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
