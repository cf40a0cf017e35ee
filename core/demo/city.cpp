#include <algorithm>

#include "core/demo/demo.h"
#include "core/demo/random.h"
#include "core/demo/shapes.h"

// Sizes from a 10 cm bollard to a 120 m tower, cables 2 cm thick and 60 m long, road markings of
// two triangles. Many faces lie in the same plane, because everything stands on the ground, and
// storeys on storeys. Many boxes interpenetrate. This makes trees of real towns hard.

namespace sightline::demo {

namespace {

constexpr double kBlock = 75;  ///< metres from street to street

/// Storeys set back on one another, flush where they meet; a cluster of small boxes on the roof.
void add_building(DemoMesh& mesh, Random& random, double x, double z, std::uint32_t boxes) {
  double half_x = random.spread(2, 16), half_z = random.spread(2, 16), y = 0;
  for (std::uint32_t i = 0; i < boxes; ++i) {
    const double height = random.spread(2.5, 40);
    add_box(mesh, {x - half_x, y, z - half_z}, {x + half_x, y + height, z + half_z});
    y += height;
    half_x *= random.between(0.5, 1);
    half_z *= random.between(0.5, 1);
  }
}

void add_cable(DemoMesh& mesh, Random& random, double x, double z, int pieces) {
  constexpr int kMost = 64;
  Vec3d points[kMost + 1];
  const double length = random.between(10, 60), y = random.between(5, 12);
  const double sag = random.between(0.01, 0.05) * length, drift = random.between(-4, 4);
  const bool along_x = (random.bits() & 1) != 0;
  for (int i = 0; i <= pieces; ++i) {
    const double s = static_cast<double>(i) / pieces;
    const double run = length * (s - 0.5), across = drift * (s - 0.5);
    points[i] = {x + (along_x ? run : across), y - 4 * sag * s * (1 - s),
                 z + (along_x ? across : run)};
  }
  add_tube(mesh, points, pieces + 1, random.between(0.01, 0.05));
}

/// Two triangles a piece, long and thin, all in the planes y = 0.01 (markings) or y = 0.12 (kerbs).
void add_strip(DemoMesh& mesh, Random& random, double x, double z) {
  const double half_length = random.spread(1, 35), half_width = random.spread(0.04, 0.4);
  const double y = (random.bits() & 1) != 0 ? 0.01 : 0.12;
  const bool along_x = (random.bits() & 1) != 0;
  const double hx = along_x ? half_length : half_width, hz = along_x ? half_width : half_length;
  const std::uint32_t a = add_vertex(mesh, x - hx, y, z - hz),
                      b = add_vertex(mesh, x - hx, y, z + hz),
                      c = add_vertex(mesh, x + hx, y, z + hz),
                      d = add_vertex(mesh, x + hx, y, z - hz);
  add_quad(mesh, a, b, c, d);
}

}  // namespace

DemoScene city(std::uint32_t triangles, std::uint64_t seed) {
  Random random(seed);
  DemoMesh mesh;
  mesh.name = "city";
  mesh.material = "concrete";
  const auto written = [&] { return mesh.indices.size() / 3; };

  std::uint32_t side = 1;
  while (std::uint64_t{side} * side * 3500 < triangles) ++side;
  const double half = side * kBlock / 2;
  const std::uint32_t a = add_vertex(mesh, -half, 0, -half), b = add_vertex(mesh, -half, 0, half),
                      c = add_vertex(mesh, half, 0, half), d = add_vertex(mesh, half, 0, -half);
  add_quad(mesh, a, b, c, d);

  // Every block gets its share of the triangles, in objects drawn by kind until the share is spent.
  const std::uint32_t blocks = side * side;
  for (std::uint32_t block = 0; block < blocks; ++block) {
    const std::uint32_t column = block % side, row = block / side;
    const double west = -half + kBlock * column, north = -half + kBlock * row;
    const std::uint64_t goal = std::uint64_t{triangles} * (block + 1) / blocks;
    while (written() + 2 <= goal) {
      const auto left = static_cast<std::uint32_t>(std::min<std::uint64_t>(goal - written(), 4096));
      const std::uint32_t kind = random.below(100);
      const double x = west + random.unit() * kBlock, z = north + random.unit() * kBlock;
      if (kind < 6 && left >= 12) {
        const double lot_x = west + 12 + random.unit() * (kBlock - 24);
        const double lot_z = north + 12 + random.unit() * (kBlock - 24);
        add_building(mesh, random, lot_x, lot_z, std::min(left / 12, 1 + random.below(6)));
      } else if (kind < 40 && left >= 12) {
        const double h = random.spread(0.05, 2), w = random.spread(0.05, 2);
        add_box(mesh, {x - w, 0, z - h}, {x + w, random.spread(0.1, 4), z + h});
      } else if (kind < 46 && left >= 8) {
        add_cable(mesh, random, x, z, static_cast<int>(std::min(left / 8, 4 + random.below(28))));
      } else if (kind < 58 && left >= 28) {
        const double height = random.between(3, 14), radius = random.spread(0.02, 0.25);
        add_column(mesh, {8, x, z, 0, height, radius, radius * random.between(0.4, 1)});
      } else {
        add_strip(mesh, random, x, z);
      }
    }
  }

  DemoScene scene;
  scene.name = "city";
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back({"city", -1, 0, {}});
  return scene;
}

}  // namespace sightline::demo
