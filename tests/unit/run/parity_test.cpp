// Inside and outside by parity: rays aimed exactly at corners and along edges of closed meshes,
// where counting triangles goes wrong and counting crossings once must not.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "core/demo/demo.h"
#include "core/demo/shapes.h"
#include "core/import/import.h"
#include "core/run/engine.h"

namespace sightline {
namespace {

constexpr std::size_t kRays = SIGHTLINE_PARITY_RAYS;  // two scenes, half of them in each
constexpr std::uint64_t kSeed = 20;

std::shared_ptr<const Scene> scene_of(const demo::DemoScene& demo_scene) {
  Result<SceneDescription> description = import_bytes(demo::write_glb(demo_scene), {});
  EXPECT_TRUE(description.ok());
  return *Scene::build(std::move(*description));
}

/// 4 x 4 x 4 boxes of side 1/2 in [0,4]^3, each in the low corner of its unit cell; those with an
/// even x are twice as long, so that they stand flush against their neighbour.
demo::DemoScene box_grid() {
  demo::DemoMesh mesh;
  mesh.name = "boxes";
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) {
      for (int z = 0; z < 4; ++z) {
        const double length = x % 2 == 0 ? 1 : 0.5;
        demo::add_box(mesh, {x * 1.0, y * 1.0, z * 1.0}, {x + length, y + 0.5, z + 0.5});
      }
    }
  }
  demo::DemoScene scene;
  scene.name = "box grid";
  scene.meshes = {std::move(mesh)};
  scene.nodes = {{"boxes", -1, 0, {}}};
  return scene;
}

/// Numbers on a coarse binary grid, so that differences to float32 corners are exact.
class Places {
 public:
  explicit Places(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  double between(int low, int high) {
    return low + static_cast<double>(below(static_cast<std::size_t>(high - low) * 1024)) / 1024;
  }
  /// In the shell of the cube [-8,8]^3 around the cube [-5,5]^3: outside of both scenes.
  Vec3d outside() {
    Vec3d place{between(-8, 8), between(-8, 8), between(-8, 8)};
    const int axis = static_cast<int>(below(3));
    place[axis] = below(2) == 0 ? between(-8, -5) : between(5, 8);
    return place;
  }
  /// Strictly inside of the ball, which is nearly of radius 1.
  Vec3d inside_ball() { return {between(-1, 1) / 2, between(-1, 1) / 2, between(-1, 1) / 2}; }
  /// Strictly inside of one box of the grid.
  Vec3d inside_box() {
    const auto offset = [&] { return static_cast<double>(1 + below(511)) / 1024; };
    const auto cell = [&] { return static_cast<double>(below(4)); };
    return {cell() + offset(), cell() + offset(), cell() + offset()};
  }

 private:
  std::mt19937_64 random_;
};

/// Whether a - b is the exact difference (the error term of TwoSum is zero).
bool exact_difference(double a, double b) {
  const double difference = a - b, b_virtual = difference - a;
  return (a - (difference - b_virtual)) - (b + b_virtual) == 0;
}

/// A corner of a triangle, or a point on an edge (exactly, but for the rare one that float64 lacks
/// the digits for).
Vec3d aim(Places& places, const WorldTriangle& triangle, bool corner) {
  const std::array<Vec3d, 3> corners{triangle.v0, triangle.v1, triangle.v2};
  const std::size_t k = places.below(3);
  const Vec3d a = corners[k], b = corners[(k + 1) % 3];
  const double part = corner ? 0 : static_cast<double>(1 + places.below(7)) / 8;
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.z + part * (b.z - a.z)};
}

struct ParityRays {
  RayBatch rays;
  std::vector<std::uint8_t> inside;
};

template <class Inside>
ParityRays rays_at_edges(const Scene& scene, std::size_t count, Places& places, Inside inside) {
  const std::uint32_t triangles = scene.description().meshes[0]->triangle_count();
  ParityRays made;
  while (made.rays.size() < count) {
    const WorldTriangle triangle =
        scene.world_triangle({0, static_cast<std::uint32_t>(places.below(triangles))});
    const std::size_t kind = made.rays.size();
    const bool from_inside = kind % 2 != 0;
    const Vec3d target = aim(places, triangle, kind / 2 % 2 == 0);
    Ray ray;
    ray.origin = from_inside ? inside() : places.outside();
    ray.direction = {target.x - ray.origin.x, target.y - ray.origin.y, target.z - ray.origin.z};
    bool exact = true;
    for (int k = 0; k < 3; ++k) exact = exact && exact_difference(target[k], ray.origin[k]);
    if (!from_inside && kind / 4 % 8 == 0) {
      // Along an edge, in the planes of the two triangles that share it.
      const Vec3d a = triangle.v0, b = triangle.v1;
      ray.direction = {b.x - a.x, b.y - a.y, b.z - a.z};
      const double back = std::exp2(16);
      for (int k = 0; k < 3; ++k) {
        ray.origin[k] = a[k] - back * ray.direction[k];
        exact = exact && exact_difference(b[k], a[k]) &&
                exact_difference(a[k], back * ray.direction[k]);
      }
      const Vec3d o = ray.origin;
      exact = exact && std::fabs(o.x) + std::fabs(o.y) + std::fabs(o.z) > 12;
    }
    if (!exact || (ray.direction.x == 0 && ray.direction.y == 0 && ray.direction.z == 0)) continue;
    made.rays.push_back(ray);
    made.inside.push_back(from_inside ? 1 : 0);
  }
  return made;
}

std::size_t wrong_parities(const Engine& engine, const Scene& scene, const ParityRays& asked,
                           Crossings crossings) {
  Column<std::uint64_t> totals;
  EXPECT_TRUE(engine.count(scene, asked.rays, crossings, Deadline::never(), totals).ok());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < totals.size(); ++i) {
    if (totals[i] % 2 != asked.inside[i]) ++wrong;
  }
  return wrong;
}

TEST(Parity, crossings_counted_once_tell_inside_from_outside_at_every_edge_and_corner) {
  auto engine = Engine::create({.threads = 2, .kernel = ""});
  ASSERT_TRUE(engine.ok());
  Places places(kSeed);
  std::printf("seed %llu, kernel %s\n", static_cast<unsigned long long>(kSeed),
              (*engine)->kernel().c_str());

  const auto ball = scene_of(demo::sphere(30000));
  const auto boxes = scene_of(box_grid());
  const ParityRays at_ball =
      rays_at_edges(*ball, kRays / 2, places, [&] { return places.inside_ball(); });
  const ParityRays at_boxes =
      rays_at_edges(*boxes, kRays - kRays / 2, places, [&] { return places.inside_box(); });

  const std::size_t wrong = wrong_parities(**engine, *ball, at_ball, Crossings::kOnce) +
                            wrong_parities(**engine, *boxes, at_boxes, Crossings::kOnce);
  std::printf("parity wrong %zu of %zu\n", wrong, kRays);
  EXPECT_EQ(wrong, 0u);

  // The rays are worth something: counting every triangle is wrong for many of their like.
  const std::size_t few = kRays / 20;
  const ParityRays like = rays_at_edges(*ball, few, places, [&] { return places.inside_ball(); });
  const std::size_t wrong_of_every = wrong_parities(**engine, *ball, like, Crossings::kEvery);
  std::printf("by every triangle that is met: wrong %zu of %zu\n", wrong_of_every, few);
  EXPECT_GT(wrong_of_every, few / 10);
}

}  // namespace
}  // namespace sightline
