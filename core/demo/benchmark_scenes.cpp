#include <cmath>

#include "core/demo/demo.h"
#include "core/demo/random.h"
#include "core/demo/shapes.h"

namespace sightline::demo {

namespace {

DemoScene single(std::string name, DemoMesh mesh) {
  DemoScene scene;
  mesh.name = name;
  mesh.material = name;
  scene.name = name;
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back({std::move(name), -1, 0, {}});
  return scene;
}

std::uint32_t side_of_square(double area) {
  const auto side = static_cast<std::uint32_t>(std::lround(std::sqrt(area)));
  return side > 0 ? side : 1;
}

}  // namespace

DemoScene terrain(std::uint32_t triangles, std::uint64_t seed) {
  DemoMesh mesh;
  add_height_field(mesh, 500, side_of_square(triangles / 2.0),
                   [&](double x, double z) { return 160 * fractal_noise(x, z, 400, 10, seed); });
  return single("terrain", std::move(mesh));
}

DemoScene soup(std::uint32_t triangles, std::uint64_t seed) {
  Random random(seed);
  DemoMesh mesh;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const double x = random.unit() * 100, y = random.unit() * 100, z = random.unit() * 100;
    const auto corner = [&] {
      const double dx = random.between(-1, 1), dy = random.between(-1, 1);
      return add_vertex(mesh, x + dx, y + dy, z + random.between(-1, 1));
    };
    const std::uint32_t a = corner(), b = corner(), c = corner();
    add_triangle(mesh, a, b, c);
  }
  return single("soup", std::move(mesh));
}

DemoScene sphere(std::uint32_t triangles, std::uint64_t seed) {
  (void)seed;  // one ball is like another; the parameter gives the five generators one signature
  DemoMesh mesh;
  add_ball(mesh, {0, 0, 0}, 1, static_cast<int>(side_of_square(triangles / 12.0)));
  return single("ball", std::move(mesh));
}

DemoScene instances(std::uint32_t copies, std::uint32_t triangles_each, std::uint64_t seed) {
  DemoScene scene = sphere(triangles_each, seed);
  scene.name = "instances";
  scene.nodes.clear();
  std::uint32_t side = 1;
  while (std::uint64_t{side} * side * side < copies) ++side;
  Random random(seed);
  for (std::uint32_t i = 0; i < copies; ++i) {
    const std::uint32_t column = i % side, row = i / side % side, layer = i / side / side;
    const double x = 3.0 * column + random.between(-0.5, 0.5);
    const double y = 3.0 * row + random.between(-0.5, 0.5);
    const double z = 3.0 * layer + random.between(-0.5, 0.5);
    const Affine rotation = random_rotation(random);
    const double sx = random.between(0.5, 1.5), sy = random.between(0.5, 1.5);
    const Affine scale = scaling(sx, sy, random.between(0.5, 1.5));
    scene.nodes.push_back(
        {"ball " + std::to_string(i + 1), -1, 0, translation(x, y, z) * (rotation * scale)});
  }
  return scene;
}

}  // namespace sightline::demo
