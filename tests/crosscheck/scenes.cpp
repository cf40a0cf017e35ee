#include "tests/crosscheck/scenes.h"

#include <algorithm>
#include <utility>

#include "core/import/import.h"
#include "tests/oracle/random.h"

namespace sightline::crosscheck {
namespace {

using demo::DemoMesh;
using demo::DemoScene;
using oracle::Random;

std::uint32_t corner(DemoMesh& mesh, double x, double y, double z) {
  for (const double value : {x, y, z}) mesh.positions.push_back(static_cast<float>(value));
  return static_cast<std::uint32_t>(mesh.positions.size() / 3 - 1);
}

DemoScene one_mesh(std::string name, DemoMesh mesh) {
  DemoScene scene;
  scene.name = std::move(name);
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back({"node", -1, 0, {}});
  return scene;
}

/// Cubes that share whole faces with their neighbours: rays in faces, along edges, and many ties.
DemoScene stacked_cubes() {
  DemoMesh mesh;
  for (int cube = 0; cube < 64; ++cube) {
    const double x = cube % 4, y = cube / 4 % 4, z = cube / 16 % 4;
    std::uint32_t v[8];
    for (std::uint32_t k = 0; k < 8; ++k)
      v[k] = corner(mesh, x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
    for (const auto& q : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                          std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
      for (const int k : {0, 1, 2, 0, 2, 3})
        mesh.indices.push_back(v[q[static_cast<std::size_t>(k)]]);
  }
  return one_mesh("stacked_cubes", std::move(mesh));
}

/// 400 triangles around one corner, as a flat fan and a pointed one.
DemoScene fans() {
  DemoMesh mesh;
  for (const double height : {0.0, 3.0}) {
    const std::uint32_t tip = corner(mesh, 0, height, 0);
    const auto rim = static_cast<std::uint32_t>(mesh.positions.size() / 3);
    for (int i = 0; i < 200; ++i)
      corner(mesh, std::cos(i * 0.0314159265), 0.25 * (i % 2), std::sin(i * 0.0314159265));
    for (std::uint32_t i = 0; i < 200; ++i)
      mesh.indices.insert(mesh.indices.end(), {tip, rim + i, rim + (i + 1) % 200});
  }
  return one_mesh("fans", std::move(mesh));
}

/// A ribbon of triangles a million times longer than wide.
DemoScene slivers() {
  Random random(7);
  DemoMesh mesh;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3d a = random.point(-10, 10);
    const Vec3d d = random.direction();
    const Vec3d s = random.direction();
    for (const auto& [along, across] : {std::pair{0.0, 0.0}, {10.0, 0.0}, {5.0, 1e-5}})
      corner(mesh, a.x + along * d.x + across * s.x, a.y + along * d.y + across * s.y,
             a.z + along * d.z + across * s.z);
    mesh.indices.insert(mesh.indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  return one_mesh("slivers", std::move(mesh));
}

/// Each triangle several times, turned and mirrored, and some without area in between.
DemoScene duplicates() {
  Random random(8);
  DemoMesh mesh;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vec3d a = random.point(-4, 4);
    for (int k = 0; k < 3; ++k)
      corner(mesh, a.x + random.integer(-2, 2), a.y + random.integer(-2, 2),
             a.z + random.integer(-2, 2));
  }
  for (int turn = 0; turn < 4; ++turn) {
    for (std::uint32_t i = 0; i < 300; ++i) {
      const std::uint32_t v = 3 * i;
      const std::uint32_t orders[4][3] = {
          {v, v + 1, v + 2}, {v + 1, v + 2, v}, {v, v + 2, v + 1}, {v, v, v + 1}};
      mesh.indices.insert(mesh.indices.end(), std::begin(orders[turn]), std::end(orders[turn]));
    }
  }
  return one_mesh("duplicates", std::move(mesh));
}

/// One ball placed mirrored, sheared, flattened, tiny, huge and far away, with overlaps.
DemoScene strange_instances() {
  DemoScene scene = demo::sphere(1200, 3);
  scene.name = "strange_instances";
  scene.nodes.clear();
  const Affine placements[] = {
      {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
      {{{-1, 0, 0, 0.5}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
      {{{1, 1000, 0, 3}, {0, 0.1, 0, 0}, {0, 0, 1, 0}}},
      {{{1, 0, 0, -3}, {0, 0, 0, 0}, {0, 0, 1, 0}}},
      {{{1e-6, 0, 0, 0}, {0, 1e-6, 0, 2}, {0, 0, 1e-6, 0}}},
      {{{0.6, -0.8, 0, 0}, {0.8, 0.6, 0, -2}, {0, 0, -1.3, 0}}},
      {{{0.1, 0, 0, 1000}, {0, 0.1, 0, 1000}, {0, 0, 0.1, -1000}}},
      {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
  };
  for (const Affine& placement : placements) scene.nodes.push_back({"ball", -1, 0, placement});
  return scene;
}

}  // namespace

SceneDescription describe(const DemoScene& scene) {
  SceneDescription result;
  result.name = scene.name;
  for (const DemoMesh& source : scene.meshes) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = source.name;
    for (std::size_t i = 0; i + 2 < source.positions.size(); i += 3)
      mesh->positions.own().push_back(
          {source.positions[i], source.positions[i + 1], source.positions[i + 2]});
    mesh->indices.own().assign(source.indices.begin(), source.indices.end());
    mesh->primitives.push_back({0, mesh->triangle_count(), 0, 0xffffffffu});
    result.meshes.push_back(std::move(mesh));
  }
  for (const demo::DemoNode& source : scene.nodes) {
    Node node;
    node.name = source.name;
    node.world_from_node = source.parent_from_node;
    if (source.parent >= 0) {
      node.parent = static_cast<std::uint32_t>(source.parent);
      node.world_from_node = result.nodes[node.parent].world_from_node * source.parent_from_node;
    }
    if (source.mesh >= 0)
      result.instances.push_back({static_cast<std::uint32_t>(source.mesh),
                                  static_cast<std::uint32_t>(result.nodes.size()),
                                  node.world_from_node});
    result.nodes.push_back(std::move(node));
  }
  return result;
}

std::vector<NamedScene> generated_scenes() {
  std::vector<NamedScene> scenes;
  const auto add = [&](std::string name, auto make) {
    scenes.push_back(
        {std::move(name), [make]() -> Result<SceneDescription> { return describe(make()); }});
  };
  add("six_triangles", [] { return demo::six_triangles(); });
  add("stacked_cubes", [] { return stacked_cubes(); });
  add("fans", [] { return fans(); });
  add("slivers", [] { return slivers(); });
  add("duplicates", [] { return duplicates(); });
  add("strange_instances", [] { return strange_instances(); });
  add("town", [] { return demo::town(); });
  add("terrain", [] { return demo::terrain(50000); });
  add("soup", [] { return demo::soup(30000); });
  add("city", [] { return demo::city(50000); });
  add("sphere", [] { return demo::sphere(20000); });
  add("instances", [] { return demo::instances(100, 1000); });
  return scenes;
}

std::vector<NamedScene> file_scenes(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
    const auto extension = entry.path().extension();
    if (extension == ".glb" || extension == ".gltf") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<NamedScene> scenes;
  scenes.reserve(files.size());
  for (const auto& file : files)
    scenes.push_back({file.filename().string(), [file] { return import_file(file, {}); }});
  return scenes;
}

}  // namespace sightline::crosscheck
