#pragma once
/// UnbuiltTrees: finds the unbuilt trees that a query needs. It may find trees that the query does
/// not need, but misses none that it needs.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/infinity.h"
#include "core/query/box_batch.h"
#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"
#include "core/trace/ray_setup.h"

namespace sightline {

struct SweepBatch;

/// The nodes and leaves of the top tree that have an unbuilt tree below them. Large batches skip the
/// others: for a camera above a scene whose near parts are built, that is most of the walk. Cost:
/// visits all nodes of the top tree. Throws std::bad_alloc.
class UnbuiltNodes {
 public:
  /// The number of queries from which on it pays.
  static constexpr std::size_t kManyQueries = 4096;
  /// The view must outlive the object.
  explicit UnbuiltNodes(const SceneView& scene);
  /// True if an unbuilt tree is below `ref` (ChildRef) of the top tree, which is not kEmpty.
  bool has(std::uint32_t ref) const;

 private:
  bool mark(std::uint32_t ref);
  const SceneTree& tree_;
  std::vector<bool> marked_;  ///< one for each granule of the top tree
};

/// Neighbouring rays as intervals of their numbers [Boulos2006]. Empty by default.
struct PacketBounds {
  Vec3d origin_min{kInf, kInf, kInf}, origin_max{-kInf, -kInf, -kInf};
  Vec3d direction_min = origin_min, direction_max = origin_max;
  double t_min = kInf, t_max = -kInf;

  /// Adds a ray up to `t`, which may be rounded.
  void include(const Ray& ray, double t);
};

/// Searches the top tree for unbuilt trees, one query at a time. Results are indices in
/// SceneTree::trees. Not thread-safe: each thread has one. It runs only while a scene has unbuilt
/// trees. Memory: the list of appended trees and a stack; functions throw
/// std::bad_alloc.
class UnbuiltTrees {
 public:
  /// The view, and the nodes if they are not null, must outlive the object.
  explicit UnbuiltTrees(const SceneView& scene, const UnbuiltNodes* nodes = nullptr);

  /// Returns the unbuilt tree whose box the ray enters first, among those that may have a hit at
  /// `t` or less within the ray's limits; kNone if there is none. `t` is the t of the closest hit
  /// in the built trees, or +inf.
  std::uint32_t nearest(const Ray& ray, double t);
  /// next[k] = nearest(rays[numbers[k]], limit(numbers[k])), or kNone where the limit is NaN or
  /// below the ray's tmin. Cost: for each packet of neighbours one search, and if it is not clear
  /// one more for each of its rays.
  template <class Limit>
  void nearest(const RayBatch& rays, std::span<const std::size_t> numbers, Limit limit,
               std::uint32_t* next);
  /// True only if no ray of the packet meets the box of an unbuilt tree. Returns false without a
  /// search for rays with tmin < 0, and for a top tree that is scaled.
  bool is_clear(const PacketBounds& packet);
  /// Appends all unbuilt trees whose boxes the ray may meet within its limits. The list may name a
  /// tree several times, as may those below.
  void met(const Ray& ray, std::vector<std::uint32_t>& trees);
  /// Returns the unbuilt tree whose box is nearest to the point, among those that may have a
  /// triangle within `distance`, in scene units; kNone if there is none.
  std::uint32_t nearest_to(const Vec3d& point, double distance);
  /// Appends all unbuilt trees whose boxes shape i of the batch may touch.
  void touched(const BoxBatch& boxes, std::size_t i, std::vector<std::uint32_t>& trees);
  /// Appends all unbuilt trees whose boxes the shape of sweep i may touch.
  void swept(const SweepBatch& sweeps, std::size_t i, std::vector<std::uint32_t>& trees);

 private:
  bool skips(std::uint32_t ref) const { return nodes_ != nullptr && !nodes_->has(ref); }
  static constexpr std::size_t kPacket = 64;  ///< rays
  template <class Found>
  void walk(const Ray& ray, double t, Found found);
  template <class Found>
  void walk(const BoxRay& box, float limit, Found found);
  template <class Children>
  void gather(Children children, std::vector<std::uint32_t>& trees);
  template <class Found>
  void unbuilt_of(std::uint32_t leaf, Found found) const;

  struct Waiting {
    std::uint32_t ref;
    float near;
  };
  const SceneTree& tree_;
  const UnbuiltNodes* const nodes_;
  const WideNode above_;
  std::vector<Waiting> waiting_;
};

template <class Limit>
void UnbuiltTrees::nearest(const RayBatch& rays, std::span<const std::size_t> numbers, Limit limit,
                           std::uint32_t* next) {
  for (std::size_t first = 0; first < numbers.size(); first += kPacket) {
    const std::size_t end = std::min(numbers.size(), first + kPacket);
    const auto is_over = [&](std::size_t i) { return !(limit(i) >= rays.tmin[i]); };
    PacketBounds packet;
    for (const std::size_t i : numbers.subspan(first, end - first)) {
      if (!is_over(i)) packet.include(rays[i], limit(i));
    }
    const bool clear = is_clear(packet);
    for (std::size_t k = first; k < end; ++k) {
      const std::size_t i = numbers[k];
      next[k] = clear || is_over(i) ? kNone : nearest(rays[i], limit(i));
    }
  }
}

}  // namespace sightline

// Tests: tests/unit/run/engine_test.cpp
