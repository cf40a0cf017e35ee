#include "core/scene/scene.h"

#include <algorithm>
#include <numeric>

#include "core/base/within_memory.h"
#include "core/scene/poser.h"

namespace sightline {

namespace {

constexpr const char* kNoMemory = "there is no memory for the scene's trees";

std::uint64_t attribute_bytes_of(const Mesh& mesh) {
  std::uint64_t bytes = 0;
  for (const PrimitiveAttributes& attributes : mesh.attributes) {
    for (const auto& entry : attributes.entries) bytes += entry.numbers->bytes();
  }
  return bytes;
}

MeshView view_of(const Mesh& mesh) { return {mesh.positions, mesh.indices, mesh.all_used}; }

/// What moved_plan and SceneTrees are told of a change.
struct Changes {
  std::vector<MovedPlacement> moved;
  std::vector<std::uint32_t> moved_numbers;
  std::vector<FreshMesh> fresh;
};

/// By the numbers of a scene's meshes: the meshes that its plan places for them.
std::vector<std::uint32_t> placed_meshes(const SceneDescription& scene, const ScenePlan& plan) {
  std::vector<std::uint32_t> placed(scene.meshes.size());
  std::iota(placed.begin(), placed.end(), 0u);
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    placed[scene.instances[i].mesh] = plan.placements[i].mesh;
  return placed;
}

/// The meshes that the plan places for nodes which have another mesh of equal content.
HeldMeshes held_meshes(const SceneDescription& scene, const ScenePlan& plan) {
  HeldMeshes held(scene.meshes.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const std::uint32_t placed = plan.placements[i].mesh;
    if (placed != instance.mesh && !scene.nodes[instance.node].removed) held[placed] = true;
  }
  return held;
}

/// `before`, `plan`: of the scene without the change.
Changes changes_of(const SceneDescription& scene, const SceneDescription& before,
                   const ScenePlan& plan, const ChangedInstances& changed) {
  Changes parts;
  const std::size_t old_instances = before.instances.size();
  std::vector<std::uint32_t> placed;
  if (scene.instances.size() > old_instances) placed = placed_meshes(before, plan);
  std::vector<bool> is_fresh(scene.meshes.size()), is_changed(scene.instances.size()),
      is_posed(scene.instances.size());
  for (const std::uint32_t i : changed.posed.fresh) {
    is_fresh[i] = true;
    parts.fresh.push_back({i, view_of(*scene.meshes[i])});
  }
  for (const std::uint32_t i : changed.posed.instances) is_posed[i] = true;
  for (const std::uint32_t i : changed.instances) is_changed[i] = true;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    // Meshes of equal content share a number in the plan: one of them may have another content now.
    const std::uint32_t mesh = i < old_instances               ? plan.placements[i].mesh
                               : instance.mesh < placed.size() ? placed[instance.mesh]
                                                               : instance.mesh;
    const bool has_own = is_posed[i] || is_fresh[mesh];
    if (!has_own && !is_changed[i]) continue;
    parts.moved_numbers.push_back(i);
    parts.moved.push_back(
        {i, instance.world_from_mesh, instance.hidden, has_own ? instance.mesh : mesh});
  }
  return parts;
}

}  // namespace

std::uint64_t geometry_bytes(const SceneDescription& scene) {
  std::uint64_t bytes = scene.poser ? scene.poser->bytes() : 0;
  for (const auto& mesh : scene.meshes) {
    bytes += mesh->positions.size() * sizeof(Vec3f) + mesh->indices.listed().size_bytes() +
             attribute_bytes_of(*mesh);
  }
  return bytes;
}

std::uint64_t overflow_bytes(const SceneDescription& scene) {
  std::uint64_t bytes = 0;
  if (scene.overflow == nullptr) return bytes;
  for (const auto& mesh : scene.meshes) {
    const std::span<const Vec3f> positions = mesh->positions;
    const auto indices = mesh->indices.listed();
    if (scene.overflow->contains(positions.data())) bytes += positions.size_bytes();
    if (scene.overflow->contains(indices.data())) bytes += indices.size_bytes();
  }
  return bytes;
}

void Scene::count() {
  geometry_bytes_.all = geometry_bytes(description_);
  geometry_bytes_.overflow = overflow_bytes(description_);
  const std::vector<bool> used = used_meshes(description_);
  for (std::size_t i = 0; i < used.size(); ++i) {
    const auto& mesh = description_.meshes[i];
    if (used[i] && mesh->triangle_count() > 0) ++shown_.meshes;
    if (used[i]) unique_triangle_count_ += mesh->triangle_count();
  }
  for (const Node& node : description_.nodes) {
    if (!node.removed) ++shown_.nodes;
  }
  for (const Instance& instance : description_.instances) {
    const Mesh& mesh = *description_.meshes[instance.mesh];
    if (!description_.nodes[instance.node].removed) ++shown_.instances;
    instanced_triangle_count_ += mesh.triangle_count();
    instanced_primitive_count_ += mesh.primitives.size();
    has_empty_mask_ = has_empty_mask_ || instance.mask == 0;
  }
}

Result<std::shared_ptr<const Scene>> Scene::prepare(SceneDescription description,
                                                    std::uint32_t tree_triangles) {
  return within_memory(kNoMemory, [&]() -> Result<std::shared_ptr<const Scene>> {
    std::shared_ptr<Scene> scene(new Scene());
    scene->description_ = std::move(description);
    scene->count();
    std::vector<MeshView> meshes;
    for (const auto& mesh : scene->description_.meshes) meshes.push_back(view_of(*mesh));
    std::vector<PlacementView> placements;
    placements.reserve(scene->description_.instances.size());
    for (const Instance& instance : scene->description_.instances) {
      placements.push_back({instance.mesh, instance.world_from_mesh, instance.hidden});
    }
    Result<ScenePlan> plan = plan_scene(std::move(meshes), std::move(placements), tree_triangles);
    if (!plan) return std::move(plan).error();
    scene->plan_ = std::move(*plan);
    scene->known_edges_ = std::make_shared<KnownEdges>(scene->description_.meshes.size());
    scene->attribute_bytes_ = std::make_shared<std::atomic<std::uint64_t>>(0);
    scene->trees_ = std::make_unique<SceneTrees>(scene->plan_, scene->geometry_bytes_);
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

Result<std::shared_ptr<const Scene>> Scene::changed(std::span<const NodeChange> changes,
                                                    std::size_t sampled) const {
  return within_memory(kNoMemory, [&]() -> Result<std::shared_ptr<const Scene>> {
    SceneDescription description = description_;
    auto changed = change_nodes(description, changes, sampled, held_meshes(description_, plan_));
    if (!changed) return std::move(changed).error();
    if (changed->posed.renumbered) return prepare(std::move(description), plan_.tree_triangles);
    std::shared_ptr<Scene> scene(new Scene());
    scene->description_ = std::move(description);
    scene->count();
    const Changes parts = changes_of(scene->description_, description_, plan_, *changed);
    auto plan = moved_plan(plan_, parts.moved, parts.fresh);
    if (!plan) return std::move(plan).error();
    scene->plan_ = *std::move(plan);
    scene->known_edges_ = parts.fresh.empty()
                              ? known_edges_
                              : std::make_shared<KnownEdges>(scene->description_.meshes.size());
    scene->attribute_bytes_ = attribute_bytes_;
    scene->trees_ = std::make_unique<SceneTrees>(scene->plan_, scene->geometry_bytes_, *trees_,
                                                 parts.moved_numbers, changed->posed.fresh);
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
