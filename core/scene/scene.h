#pragma once
/// An immutable scene: what every reader of a revision shares.

#include <atomic>
#include <cstdint>
#include <memory>
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

/// A triangle of the scene in the world: the truth that every answer is about.
using WorldTriangle = Triangle;

/// Nothing that an answer depends on ever changes; hold it by shared_ptr<const Scene> for as long
/// as it is read. Its trees are a cache that fills while it is used.
class Scene {
 public:
  /// Knows its bounds and has no tree yet. Errors: SCENE_TOO_LARGE when a tree would not fit,
  /// MEMORY_EXHAUSTED.
  static Result<std::shared_ptr<const Scene>> prepare(SceneDescription description);
  /// Has all trees. Errors: as prepare; CANCELLED.
  static Result<std::shared_ptr<const Scene>> build(SceneDescription description,
                                                    TreeQuality quality = TreeQuality::kHigh,
                                                    Joining joining = Joining::kMeasured,
                                                    const CancelFlag* cancel = nullptr);
  /// This scene with some nodes moved or hidden. It shares the meshes, and the trees of everything
  /// that has not moved. Errors: those of change_nodes, MEMORY_EXHAUSTED.
  Result<std::shared_ptr<const Scene>> changed(std::span<const NodeChange> changes) const;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const SceneDescription& description() const { return description_; }
  /// Never null. A query takes it once, in a SceneView.
  std::shared_ptr<const SceneTree> tree() const { return trees_->now(); }
  /// To build them, drop them, or ask what they cost: nothing of it changes an answer.
  SceneTrees& trees() const { return *trees_; }

  /// Every triangle of every instance, dropped ones included.
  std::uint64_t instanced_triangle_count() const { return instanced_triangle_count_; }
  /// Every primitive of every instance.
  std::uint64_t instanced_primitive_count() const { return instanced_primitive_count_; }
  /// Every triangle of every mesh, dropped ones included.
  std::uint64_t unique_triangle_count() const { return unique_triangle_count_; }
  /// The bounds of the world positions that finite triangles use (area or not); empty if there is
  /// none.
  const Box3d& bounds() const { return plan_.bounds; }

  /// Counts the bytes of vertex attributes that were read from the file for hits. Scenes that share
  /// meshes share the counter.
  std::atomic<std::uint64_t>& attribute_bytes() const { return *attribute_bytes_; }

  /// Whether some instance has mask 0: no ray meets it, whatever its own mask.
  bool has_empty_mask() const { return has_empty_mask_; }

  /// Precondition: id names a triangle of this scene.
  WorldTriangle world_triangle(TriangleId id) const;
  /// The primitive of the instance's mesh that holds this triangle, as an index in
  /// Mesh::primitives.
  std::uint32_t primitive_of(TriangleId id) const;
  /// The open edges of a whole mesh of the description; see KnownEdges. Throws std::bad_alloc.
  Result<OpenEdges> open_edges(std::uint32_t mesh, const Deadline& deadline,
                               const ReserveBytes& reserve) const;

 private:
  Scene() = default;
  SceneDescription description_;
  ScenePlan plan_;
  std::unique_ptr<SceneTrees> trees_;        ///< refers to plan_
  std::shared_ptr<KnownEdges> known_edges_;  ///< shared with the scenes that share the meshes
  std::shared_ptr<std::atomic<std::uint64_t>> attribute_bytes_;
  std::uint64_t unique_triangle_count_ = 0;
  std::uint64_t instanced_triangle_count_ = 0;
  std::uint64_t instanced_primitive_count_ = 0;
  bool has_empty_mask_ = false;
};

}  // namespace sightline

// Tests: tests/unit/scene/scene_trees_test.cpp
