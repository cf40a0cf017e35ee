#pragma once
/// Which trees that are not built yet a query comes near: conservative, never one too few.

#include <cstdint>
#include <vector>

#include "core/query/box_batch.h"
#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

struct SweepBatch;

/// Finds unbuilt trees by the tree over the placements, one query at a time. Trees are named by
/// their index in SceneTree::trees. It uses no vectors, because it runs only while a scene is new.
class UnbuiltTrees {
 public:
  /// The view outlives it.
  explicit UnbuiltTrees(const SceneView& scene) : tree_(scene.tree()) {}

  /// The tree whose box the ray enters first, of those that may hold a hit with at most this t,
  /// within the limits of the ray. kNone if there is none. t as rounded by Sightline, or +inf.
  std::uint32_t nearest(const Ray& ray, double t);
  /// Appends all whose boxes the ray may meet within its limits.
  void met(const Ray& ray, std::vector<std::uint32_t>& trees);
  /// The tree whose box is nearest to the point, of those that may be within `distance`. kNone if
  /// there is none.
  std::uint32_t nearest_to(const Vec3d& point, double distance);
  /// Appends all whose boxes the box may touch.
  void touched(const BoxBatch& boxes, std::size_t i, std::vector<std::uint32_t>& trees);
  /// Appends all whose boxes the shape may touch on its way.
  void swept(const SweepBatch& sweeps, std::size_t i, std::vector<std::uint32_t>& trees);

 private:
  template <class Found>
  void walk(const Ray& ray, double t, Found found);
  template <class Children>
  void gather(Children children, std::vector<std::uint32_t>& trees);
  template <class Found>
  void unbuilt_of(std::uint32_t leaf, Found found) const;

  struct Waiting {
    std::uint32_t ref;
    float near;
  };
  const SceneTree& tree_;
  std::vector<Waiting> waiting_;
};

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
