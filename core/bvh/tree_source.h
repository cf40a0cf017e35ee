#pragma once
/// Sources of the trees of a scene: a builder, or a file that an earlier run wrote.

#include <functional>
#include <memory>
#include <span>

#include "core/bvh/scene_tree.h"
#include "core/bvh/triangle_tree.h"

namespace sightline {

/// Called for every tree of a scene, always in one order, the top last.
struct TreeSource {
  /// Around the triangles of all parts, as build_triangle_tree makes it.
  std::function<Result<std::shared_ptr<const WideTree>>(std::span<const TreePart> parts)> triangles;
  /// A tree over boxes, as build_top makes it.
  std::function<Result<WideTree>(std::span<const Box3d> boxes, const Box3d& all)> top;
};

/// Assembles the trees of a scene. Errors: those of the source.
Result<SceneTree> assemble_scene_tree(const ScenePlan& plan, Joining joining,
                                      const TreeSource& source);

}  // namespace sightline

// Tests: tests/unit/scene/tree_cache_test.cpp
