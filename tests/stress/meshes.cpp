#include "tests/stress/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::stress {
namespace {

constexpr double kPi = 3.141592653589793;

}  // namespace

std::uint32_t MeshMaker::corner(double x, double y, double z) {
  mesh_.positions.own().push_back(
      {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void MeshMaker::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  for (const std::uint32_t index : {a, b, c}) mesh_.indices.own().push_back(index);
}

void MeshMaker::triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const std::uint32_t first = corner(a);
  corner(b);
  corner(c);
  triangle(first, first + 1, first + 2);
}

void MeshMaker::box(const Vec3d& min, const Vec3d& max) {
  std::uint32_t first = 0;
  for (unsigned k = 0; k < 8; ++k) {
    const std::uint32_t v = corner((k & 1) != 0 ? max.x : min.x, (k & 2) != 0 ? max.y : min.y,
                                   (k & 4) != 0 ? max.z : min.z);
    if (k == 0) first = v;
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : kFaces) {
    triangle(first + f[0], first + f[1], first + f[2]);
    triangle(first + f[0], first + f[2], first + f[3]);
  }
}

void MeshMaker::ball(Random& random, const Vec3d& center, double radius, int rows, int columns,
                     double bump) {
  const std::uint32_t top = corner(center.x, center.y, center.z + radius);
  const auto rim = static_cast<std::uint32_t>(mesh_.positions.size());
  for (int i = 1; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double a = kPi * i / rows;
      const double b = 2 * kPi * j / columns;
      const double r = radius * (1 + random.between(-bump, bump));
      corner(center.x + r * std::sin(a) * std::cos(b), center.y + r * std::sin(a) * std::sin(b),
             center.z + r * std::cos(a));
    }
  }
  const std::uint32_t bottom = corner(center.x, center.y, center.z - radius);
  const auto at = [&](int i, int j) {
    if (i == 0) return top;
    if (i == rows) return bottom;
    return rim + static_cast<std::uint32_t>(i - 1) * static_cast<std::uint32_t>(columns) +
           static_cast<std::uint32_t>(j % columns);
  };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      if (i > 0) triangle(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + 1 < rows) triangle(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  }
}

std::shared_ptr<const Mesh> MeshMaker::finish() {
  mesh_.name = "mesh";
  mesh_.primitives.push_back({0, mesh_.triangle_count(), 0, 0xffffffffu});
  return std::make_shared<const Mesh>(std::move(mesh_));
}

SceneDescription scene_of(std::vector<MeshPointer> meshes, const std::vector<Affine>& placements) {
  SceneDescription scene;
  scene.name = "stress";
  scene.meshes = std::move(meshes);
  for (std::size_t i = 0; i < placements.size(); ++i)
    place(scene, static_cast<std::uint32_t>(std::min(i, scene.meshes.size() - 1)), placements[i]);
  return scene;
}

SceneDescription scene_of(MeshPointer mesh) { return scene_of({std::move(mesh)}, {Affine{}}); }

void place(SceneDescription& scene, std::uint32_t mesh, const Affine& world_from_mesh) {
  Node node;
  node.name = "node " + std::to_string(scene.nodes.size());
  node.world_from_node = world_from_mesh;
  scene.instances.push_back(
      {mesh, static_cast<std::uint32_t>(scene.nodes.size()), world_from_mesh});
  scene.nodes.push_back(std::move(node));
}

Affine translation(double x, double y, double z) {
  return {{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
}

Affine scaling(double x, double y, double z) {
  return {{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}}};
}

Affine rotation(Random& random) {
  const Vec3d axis = random.direction();
  const double angle = random.between(-kPi, kPi);
  const double c = std::cos(angle), s = std::sin(angle), k = 1 - c;
  const auto [x, y, z] = axis;
  return {{{c + k * x * x, k * x * y - s * z, k * x * z + s * y, 0},
           {k * x * y + s * z, c + k * y * y, k * y * z - s * x, 0},
           {k * x * z - s * y, k * y * z + s * x, c + k * z * z, 0}}};
}

std::vector<Triangle> world(const SceneDescription& scene) {
  std::vector<Triangle> triangles;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    const auto at = [&](std::size_t i) {
      return instance.world_from_mesh.apply(mesh.positions[mesh.indices[i]]);
    };
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
      triangles.push_back({at(i), at(i + 1), at(i + 2)});
  }
  return triangles;
}

MeshPointer scan(Random& random, int triangles) {
  const int rows = std::max(3, static_cast<int>(std::sqrt(triangles / 4.0)));
  MeshMaker maker;
  maker.ball(random, {0.125, -0.25, 0.0625}, 1, rows, 2 * rows, 0.02);
  return maker.finish();
}

MeshPointer stacked_cubes(int n) {
  MeshMaker maker;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        const Vec3d min{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        maker.box(min, {min.x + 1, min.y + 1, min.z + 1});
      }
    }
  }
  return maker.finish();
}

MeshPointer soup(Random& random, int count, double side) {
  MeshMaker maker;
  for (int i = 0; i < count; ++i) {
    const Vec3d a = random.point(-side / 2, side / 2);
    const Vec3d b = random.point(-1, 1);
    const Vec3d c = random.point(-1, 1);
    maker.triangle(a, {a.x + b.x, a.y + b.y, a.z + b.z}, {a.x + c.x, a.y + c.y, a.z + c.z});
  }
  return maker.finish();
}

}  // namespace sightline::stress
