#include "core/scene/scene.h"

#include <algorithm>
#include <new>

namespace sightline {

Result<std::shared_ptr<const Scene>> Scene::build(SceneDescription description, TreeQuality quality,
                                                  Joining joining) {
  std::shared_ptr<Scene> scene(new Scene());
  scene->description_ = std::move(description);
  std::vector<MeshView> meshes;
  for (const auto& mesh : scene->description_.meshes) {
    scene->unique_triangle_count_ += mesh->triangle_count();
    meshes.push_back({mesh->positions, mesh->indices});
  }
  std::vector<PlacementView> placements;
  for (const Instance& instance : scene->description_.instances) {
    scene->instanced_triangle_count_ += meshes[instance.mesh].triangle_count();
    placements.push_back({instance.mesh, instance.world_from_mesh});
  }
  try {
    Result<SceneTree> tree = build_scene_tree(meshes, placements, quality, joining);
    if (!tree) return std::move(tree).error();
    scene->tree_ = std::make_shared<const SceneTree>(std::move(*tree));
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::kOutOfSpace, "MEMORY_EXHAUSTED",
                 "there is no memory for the scene's trees", ""};
  }
  return std::shared_ptr<const Scene>(std::move(scene));
}

WorldTriangle Scene::world_triangle(TriangleId id) const {
  const Instance& instance = description_.instances[id.instance];
  const Mesh& mesh = *description_.meshes[instance.mesh];
  const std::uint32_t* corner = &mesh.indices[std::size_t{id.triangle} * 3];
  return {instance.world_from_mesh.apply(mesh.positions[corner[0]]),
          instance.world_from_mesh.apply(mesh.positions[corner[1]]),
          instance.world_from_mesh.apply(mesh.positions[corner[2]])};
}

std::uint32_t Scene::primitive_of(TriangleId id) const {
  const auto& primitives =
      description_.meshes[description_.instances[id.instance].mesh]->primitives;
  const auto after = std::upper_bound(
      primitives.begin(), primitives.end(), id.triangle,
      [](std::uint32_t triangle, const Primitive& p) { return triangle < p.first_triangle; });
  return static_cast<std::uint32_t>(after - primitives.begin()) - 1;
}

}  // namespace sightline
