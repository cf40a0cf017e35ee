#include "tests/contestants/unrounded_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "core/trace/kernel/kernel.h"
#include "tests/oracle/random.h"

namespace sightline::contestants {
namespace {

/// 500 triangles with sides up to a fifth of the scene.
std::shared_ptr<const Scene> make_soup(oracle::Random& random) {
  auto mesh = std::make_shared<Mesh>();
  const auto number = [&](double low, double high) {
    return static_cast<float>(random.between(low, high));
  };
  for (std::uint32_t i = 0; i < 500; ++i) {
    const Vec3f at{number(-1, 1), number(-1, 1), number(-1, 1)};
    for (std::uint32_t c = 0; c < 3; ++c) {
      mesh->positions.own().push_back(
          {at.x + number(-0.2, 0.2), at.y + number(-0.2, 0.2), at.z + number(-0.2, 0.2)});
      mesh->indices.own().push_back(3 * i + c);
    }
  }
  mesh->primitives.push_back({0, 500, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  description.nodes.push_back({});
  description.instances.push_back({});
  auto scene = Scene::build(std::move(description), TreeQuality::kHigh);
  EXPECT_TRUE(scene.ok());
  return *scene;
}

TEST(UnroundedKernel, names_the_products_triangles_but_its_t_is_not_the_rounded_one) {
  oracle::Random random(20250707);
  const auto scene = make_soup(random);
  ASSERT_TRUE(can_trace_unrounded(*scene));
  RayBatch rays;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d origin = random.point(-3, 3), at = random.point(-1, 1);
    rays.push_back({origin, {at.x - origin.x, at.y - origin.y, at.z - origin.z}});
  }
  // Neighbours, which go as packets where packets work.
  for (int i = 0; i < 2000; ++i) {
    rays.push_back({{0, 0, 4}, {0.5 + 1e-4 * i, 0.5 + 1e-5 * i, -2}});
  }
  HitBatch ours, plain;
  ours.resize(rays.size());
  plain.resize(rays.size());
  TraceCounts counts;
  supported_kernels().front().closest(*scene, rays, 0, rays.size(), ours, counts);
  unrounded_kernel().closest(*scene, rays, 0, rays.size(), plain);

  int hits = 0, same = 0, near = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(plain.id(i), ours.id(i)) << i;
    if (!ours.hit(i)) {
      EXPECT_EQ(plain.t[i], std::numeric_limits<double>::infinity());
      continue;
    }
    ++hits;
    same += plain.t[i] == ours.t[i] ? 1 : 0;
    near += std::abs(plain.t[i] - ours.t[i]) <= 0x1p-51 * ours.t[i] ? 1 : 0;
  }
  std::printf("%d hits, t is the rounded one of %d, within 4 ulp of %d\n", hits, same, near);
  EXPECT_GT(hits, 1000);
  EXPECT_LT(same, hits);
  EXPECT_GT(2 * near, hits);
}

}  // namespace
}  // namespace sightline::contestants
