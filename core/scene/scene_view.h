#pragma once
/// SceneView: a scene with the trees that it had when a query began.

#include <memory>
#include <utility>

#include "core/scene/scene.h"

namespace sightline {

/// The part of a scene that a kernel reads. The trees of a scene may be replaced while queries run;
/// a view retains the trees that it was made with. The scene must outlive the view.
class SceneView {
 public:
  /// A view with the present trees. Implicit, so that a Scene can be passed where a view is needed.
  SceneView(const Scene& scene) : SceneView(scene, scene.tree()) {}  // NOLINT(*-explicit-*)
  /// A view with other trees of the scene, such as those of SceneTrees::build; `tree` is not null.
  SceneView(const Scene& scene, std::shared_ptr<const SceneTree> tree)
      : scene_(&scene), tree_(std::move(tree)) {}

  const SceneTree& tree() const { return *tree_; }
  const std::shared_ptr<const SceneTree>& shared_tree() const { return tree_; }
  const Scene& scene() const { return *scene_; }
  const SceneDescription& description() const { return scene_->description(); }
  WorldTriangle world_triangle(TriangleId id) const { return scene_->world_triangle(id); }

 private:
  const Scene* scene_;
  std::shared_ptr<const SceneTree> tree_;
};

}  // namespace sightline

// Tests: tests/unit/trace/box_overlap_test.cpp
