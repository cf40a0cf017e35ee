#pragma once
/// TreeSource: where assemble_scene_tree gets the trees of a scene from: a builder, or a file with
/// trees that an earlier run wrote.

#include <functional>
#include <memory>
#include <span>

#include "core/bvh/scene_tree.h"
#include "core/bvh/triangle_tree.h"

namespace sightline {

/// Functions that assemble_scene_tree calls for the trees of a scene, on its thread, in an
/// order that the plan fixes, the top tree last.
struct TreeSource {
  /// Returns the tree around the triangles of all parts, like build_triangle_tree; not null.
  std::function<Result<std::shared_ptr<const WideTree>>(std::span<const TreePart> parts)> triangles;
  /// Returns a tree over the world bounds of the entries, like build_top. `all` contains the boxes.
  std::function<Result<WideTree>(std::span<const Box3d> boxes, const Box3d& all)> top;
  /// Called with each tree of `triangles` that placements do not share in world space; may be empty.
  std::function<void(FinishedTree finished)> finished = {};
};

/// Assembles the trees of a scene from the results of `source`. Errors: those of the source. Throws
/// std::bad_alloc.
Result<SceneTree> assemble_scene_tree(const ScenePlan& plan, Joining joining,
                                      const TreeSource& source);

}  // namespace sightline

// Tests: tests/unit/scene/tree_cache_test.cpp
