#pragma once
/// Scene: an immutable scene, which all readers of a revision share.

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/bvh/scene_tree.h"
#include "core/geometry/box3.h"
#include "core/geometry/triangle.h"
#include "core/query/hit_batch.h"
#include "core/scene/node_changes.h"
#include "core/scene/open_edges.h"
#include "core/scene/scene_description.h"
#include "core/scene/scene_trees.h"

namespace sightline {

/// A triangle of the scene in world space, in float64. All answers are about world triangles.
using WorldTriangle = Triangle;

/// A scene that queries read: prepare() or build() makes it, changed() makes a copy. Nothing
/// changes that an answer depends on. Its trees are a cache that is filled when queries need them.
/// Readers hold it by shared_ptr<const Scene>; all functions are thread-safe.
class Scene {
 public:
  /// Makes a scene with its bounds, but no tree built. Errors: SCENE_TOO_LARGE if a mesh or the
  /// number of placements is (plan_scene), MEMORY_EXHAUSTED.
  static Result<std::shared_ptr<const Scene>> prepare(
      SceneDescription description, std::uint32_t tree_triangles = kTreeTriangles);
  /// Makes a scene with all trees built. Errors: those of prepare; CANCELLED.
  static Result<std::shared_ptr<const Scene>> build(SceneDescription description,
                                                    TreeQuality quality = TreeQuality::kHigh,
                                                    Joining joining = Joining::kMeasured,
                                                    const CancelFlag* cancel = nullptr);
  /// Makes a copy of this scene with some nodes changed. The copy shares the meshes that have the
  /// same pose, and the trees of everything that did not move. `sampled` is that of change_nodes.
  /// Errors: those of change_nodes, SCENE_TOO_LARGE, MEMORY_EXHAUSTED.
  Result<std::shared_ptr<const Scene>> changed(std::span<const NodeChange> changes,
                                               std::size_t sampled = 0) const;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const SceneDescription& description() const { return description_; }
  /// The present trees; never null. A query reads them once, in a SceneView.
  std::shared_ptr<const SceneTree> tree() const { return trees_->now(); }
  /// The cache of trees: to build or drop trees, or for statistics. That does not change answers,
  /// so the function is const.
  SceneTrees& trees() const { return *trees_; }

  /// How many the scene has, without those that were removed.
  struct Counts {
    std::uint64_t nodes = 0, instances = 0, meshes = 0;
  };
  const Counts& counts() const { return shown_; }
  /// The number of triangles of all instances, including triangles that no ray can hit.
  std::uint64_t instanced_triangle_count() const { return instanced_triangle_count_; }
  /// The number of primitives of all instances.
  std::uint64_t instanced_primitive_count() const { return instanced_primitive_count_; }
  /// The number of triangles of all meshes, including triangles that no ray can hit.
  std::uint64_t unique_triangle_count() const { return unique_triangle_count_; }
  /// The bounds of all world triangles with finite corners, with or without an area; empty if there
  /// are none.
  const Box3d& bounds() const { return plan_.bounds; }

  /// The number of bytes of vertex attributes that were read from the file for hits. Scenes that
  /// share meshes share the counter.
  std::atomic<std::uint64_t>& attribute_bytes() const { return *attribute_bytes_; }

  /// True if an instance has the mask 0: no ray meets it, whatever the ray's mask.
  bool has_empty_mask() const { return has_empty_mask_; }

  /// The corners of a triangle in world space. Precondition: id names a triangle of this scene.
  WorldTriangle world_triangle(TriangleId id) const;
  /// The primitive that contains a triangle: index in Mesh::primitives of the instance's mesh.
  std::uint32_t primitive_of(TriangleId id) const;
  /// The triangle of a name; empty if the scene has none.
  std::optional<TriangleId> find_triangle(const TriangleName& name) const;
  /// The open edges of a whole mesh (KnownEdges). Throws std::bad_alloc.
  Result<OpenEdges> open_edges(std::uint32_t mesh, const Deadline& deadline,
                               const ReserveBytes& reserve) const;

 private:
  Scene() = default;
  /// Sets the members that count what description_ has.
  void count();
  SceneDescription description_;
  ScenePlan plan_;
  std::unique_ptr<SceneTrees> trees_;        ///< refers to plan_
  std::shared_ptr<KnownEdges> known_edges_;  ///< shared with the scenes that share the meshes
  std::shared_ptr<std::atomic<std::uint64_t>> attribute_bytes_;
  SceneTrees::GeometryBytes geometry_bytes_;
  std::uint64_t unique_triangle_count_ = 0;
  std::uint64_t instanced_triangle_count_ = 0;
  std::uint64_t instanced_primitive_count_ = 0;
  Counts shown_;
  bool has_empty_mask_ = false;
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
