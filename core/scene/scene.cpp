#include "core/scene/scene.h"

#include <algorithm>

#include "core/base/within_memory.h"

namespace sightline {

namespace {

constexpr const char* kNoMemory = "there is no memory for the scene's trees";

bool has_empty_mask_among(const std::vector<Instance>& instances) {
  return std::any_of(instances.begin(), instances.end(),
                     [](const Instance& instance) { return instance.mask == 0; });
}

std::uint64_t attribute_bytes_of(const Mesh& mesh) {
  std::uint64_t bytes = 0;
  for (const PrimitiveAttributes& attributes : mesh.attributes) {
    for (const auto& numbers : attributes.numbers) bytes += numbers ? numbers->bytes() : 0;
  }
  return bytes;
}

}  // namespace

Result<std::shared_ptr<const Scene>> Scene::prepare(SceneDescription description,
                                                    std::uint32_t tree_triangles) {
  return within_memory(kNoMemory, [&]() -> Result<std::shared_ptr<const Scene>> {
    std::shared_ptr<Scene> scene(new Scene());
    scene->description_ = std::move(description);
    std::vector<MeshView> meshes;
    std::uint64_t bytes = 0;
    for (const auto& mesh : scene->description_.meshes) {
      scene->unique_triangle_count_ += mesh->triangle_count();
      meshes.push_back({mesh->positions, mesh->indices, mesh->all_used});
      bytes += meshes.back().positions.size_bytes() + meshes.back().indices.listed().size_bytes() +
               attribute_bytes_of(*mesh);
    }
    std::vector<PlacementView> placements;
    for (const Instance& instance : scene->description_.instances) {
      scene->instanced_triangle_count_ += meshes[instance.mesh].triangle_count();
      scene->instanced_primitive_count_ +=
          scene->description_.meshes[instance.mesh]->primitives.size();
      placements.push_back({instance.mesh, instance.world_from_mesh, instance.hidden});
    }
    scene->has_empty_mask_ = has_empty_mask_among(scene->description_.instances);
    Result<ScenePlan> plan = plan_scene(std::move(meshes), std::move(placements), tree_triangles);
    if (!plan) return std::move(plan).error();
    scene->plan_ = std::move(*plan);
    scene->known_edges_ = std::make_shared<KnownEdges>(scene->description_.meshes.size());
    scene->attribute_bytes_ = std::make_shared<std::atomic<std::uint64_t>>(0);
    scene->trees_ = std::make_unique<SceneTrees>(scene->plan_, bytes);
    return std::shared_ptr<const Scene>(std::move(scene));
  });
}

Result<std::shared_ptr<const Scene>> Scene::build(SceneDescription description, TreeQuality quality,
                                                  Joining joining, const CancelFlag* cancel) {
  auto scene = prepare(std::move(description));
  if (!scene) return scene;
  return within_memory(kNoMemory, [&]() -> Result<std::shared_ptr<const Scene>> {
    Result<SceneTree> tree = build_scene_tree((*scene)->plan_, quality, joining, cancel);
    if (!tree) return std::move(tree).error();
    (*scene)->trees_->complete(std::move(*tree), SceneTrees::Origin::kBuilt);
    return scene;
  });
}

Result<std::shared_ptr<const Scene>> Scene::changed(std::span<const NodeChange> changes) const {
  return within_memory(kNoMemory, [&]() -> Result<std::shared_ptr<const Scene>> {
    std::shared_ptr<Scene> scene(new Scene());
    scene->description_ = description_;
    auto instances = change_nodes(scene->description_, changes);
    if (!instances) return std::move(instances).error();
    std::vector<MovedPlacement> moved;
    for (const std::uint32_t i : *instances) {
      const Instance& instance = scene->description_.instances[i];
      moved.push_back({i, instance.world_from_mesh, instance.hidden});
    }
    scene->plan_ = moved_plan(plan_, moved);
    scene->known_edges_ = known_edges_;
    scene->attribute_bytes_ = attribute_bytes_;
    scene->unique_triangle_count_ = unique_triangle_count_;
    scene->instanced_triangle_count_ = instanced_triangle_count_;
    scene->instanced_primitive_count_ = instanced_primitive_count_;
    scene->has_empty_mask_ = has_empty_mask_among(scene->description_.instances);
    scene->trees_ = std::make_unique<SceneTrees>(scene->plan_, *trees_, *instances);
    return std::shared_ptr<const Scene>(std::move(scene));
  });
}

WorldTriangle Scene::world_triangle(TriangleId id) const {
  const Instance& instance = description_.instances[id.instance];
  const Mesh& mesh = *description_.meshes[instance.mesh];
  const auto corner = mesh.indices.corners(id.triangle);
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

std::optional<TriangleId> Scene::find_triangle(const TriangleName& name) const {
  if (name.instance >= description_.instances.size()) return std::nullopt;
  for (const Primitive& part :
       description_.meshes[description_.instances[name.instance].mesh]->primitives) {
    if (part.file_primitive != name.primitive) continue;
    if (name.triangle >= part.triangle_count) return std::nullopt;
    return TriangleId{name.instance, part.first_triangle + name.triangle};
  }
  return std::nullopt;
}

Result<OpenEdges> Scene::open_edges(std::uint32_t mesh, const Deadline& deadline,
                                    const ReserveBytes& reserve) const {
  return known_edges_->of(mesh, *description_.meshes[mesh], deadline, reserve);
}

}  // namespace sightline
