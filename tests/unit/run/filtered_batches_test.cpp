// Filters in batches: every way through a kernel leaves out the triangles that a single ray leaves
// out.

#include <gtest/gtest.h>

#include "core/base/infinity.h"
#include "core/demo/demo.h"
#include "core/geometry/exact_hit.h"
#include "core/import/import.h"
#include "core/trace/kernel/kernel.h"
#include "tests/oracle/random.h"
#include "tests/support/float_text.h"

namespace sightline {
namespace {

constexpr std::size_t kRays = 2048;

std::shared_ptr<const Scene> small_town() {
  Result<SceneDescription> description = import_bytes(demo::write_glb(demo::town()), {});
  EXPECT_TRUE(description.ok());
  return *Scene::build(std::move(*description));
}

/// The direction of a camera: an axis, or minus an axis.
struct View {
  int axis;
  double sign;
};

/// Rows of a camera, or rays that point anywhere, from anywhere.
RayBatch rays_of(const Scene& scene, oracle::Random& random, const std::optional<View>& camera) {
  const Box3d& bounds = scene.bounds();
  const auto inside = [&] {
    Vec3d p;
    for (int k = 0; k < 3; ++k) p[k] = random.between(bounds.min[k], bounds.max[k]);
    return p;
  };
  RayBatch rays;
  const Vec3d eye = inside();
  for (std::size_t i = 0; i < kRays; ++i) {
    if (camera) {
      const std::size_t row = i / 64;
      const double x = static_cast<double>(i % 64) / 32 - 1, y = static_cast<double>(row) / 16 - 1;
      Vec3d direction;
      direction[camera->axis] = 1.25 * camera->sign;
      direction[(camera->axis + 1) % 3] = x;
      direction[(camera->axis + 2) % 3] = y;
      rays.push_back({eye, direction});
    } else {
      rays.push_back({inside(), random.direction()});
    }
    rays.mask.push_back(static_cast<std::uint32_t>(random.integer(0, 15)));
  }
  return rays;
}

/// Sides at random, mostly all or none; masks in every other filter.
ResolvedFilter sides_of(const Scene& scene, oracle::Random& random, bool masks) {
  constexpr std::uint8_t kSome[] = {ResolvedFilter::kAll, ResolvedFilter::kAll, 0,
                                    ResolvedFilter::kFront, ResolvedFilter::kBack};
  ResolvedFilter kept;
  for (const Instance& instance : scene.description().instances) {
    kept.first.push_back(kept.sides.size());
    const std::size_t primitives = scene.description().meshes[instance.mesh]->primitives.size();
    for (std::size_t i = 0; i < primitives; ++i) kept.sides.push_back(kSome[random.index(5)]);
    if (masks) kept.masks.push_back(static_cast<std::uint32_t>(random.integer(0, 15)));
  }
  return kept;
}

/// True if hits of the ray on the triangle count, by the exact sign of its side.
bool counts_exactly(const Scene& scene, const ResolvedFilter& kept, const Ray& ray, TriangleId id) {
  const int sign = side_sign(ray.direction, scene.world_triangle(id));
  const std::uint8_t met = sign < 0   ? ResolvedFilter::kFront
                           : sign > 0 ? ResolvedFilter::kBack
                                      : ResolvedFilter::kEdgeOn;
  return (kept.sides[kept.first[id.instance] + scene.primitive_of(id)] & met) != 0;
}

TEST(Filtered, batches_answer_as_single_rays) {
  const auto scene = small_town();
  const SceneView view(*scene);
  oracle::Random random(20251125);
  std::size_t hits_of_all = 0;
  for (const bool masks : {false, true}) {
    for (const std::optional<View>& camera : std::initializer_list<std::optional<View>>{
             View{0, 1}, View{0, -1}, View{1, 1}, View{1, -1}, View{2, 1}, View{2, -1}, {}}) {
      const RayBatch rays = rays_of(*scene, random, camera);
      const ResolvedFilter kept = sides_of(*scene, random, masks);
      for (const Kernel& kernel : supported_kernels()) {
        TraceCounts counts;
        HitBatch together, single;
        together.resize(kRays);
        single.resize(kRays);
        Column<std::uint8_t> any_together(kRays), any_single(kRays);
        kernel.closest_filtered(view, rays, 0, kRays, kept, together, counts);
        kernel.any_filtered(view, rays, 0, kRays, kept, any_together.data(), counts);
        for (std::size_t i = 0; i < kRays; ++i) {
          kernel.closest_filtered(view, rays, i, i + 1, kept, single, counts);
          kernel.any_filtered(view, rays, i, i + 1, kept, any_single.data(), counts);
        }
        for (std::size_t i = 0; i < kRays; ++i) {
          ASSERT_TRUE(test::same_bits(together.t[i], single.t[i])) << kernel.name << " ray " << i;
          ASSERT_EQ(together.instance[i], single.instance[i]) << kernel.name << " ray " << i;
          ASSERT_EQ(together.triangle[i], single.triangle[i]) << kernel.name << " ray " << i;
          if (!single.hit(i)) continue;
          ++hits_of_all;
          const TriangleId id{single.instance[i], single.triangle[i]};
          ASSERT_TRUE(counts_exactly(*scene, kept, rays[i], id)) << kernel.name << " ray " << i;
        }
        EXPECT_EQ(any_together, any_single) << kernel.name;
      }
    }
  }
  EXPECT_GT(hits_of_all, kRays);
}

}  // namespace
}  // namespace sightline
