#pragma once
/// Traversal of scenes beyond the memory budget, one group of trees after the other. [Pharr1997]
///
/// Incoherent rays read most trees of a scene, each ray in an order of its own. Beyond the budget
/// each step then waits for the disk, and the process maps more memory than it may.
///
/// Method   trees in OverflowMemory are divided into groups, in the order of their addresses. Each
///          group is read once for a batch, if all trees are built: all rays that may meet it are
///          traced in it alone, then its pages are unmapped. The answer of a ray is the best of its
///          groups, so it does not depend on the groups (law 1).

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// The groups of the built trees of a view. Unbuilt trees are in none. The first group has the
/// trees that are not in OverflowMemory, if there are any. The scene must outlive the object.
class TreeGroups {
 public:
  /// The most groups, and the bytes of a group in parts of what OverflowMemory may have in memory.
  static constexpr std::size_t kMost = 64, kPartOfLimit = 8;
  /// Smaller batches are traced in all trees at once, and so many rays of larger ones are a sample.
  static constexpr std::size_t kSample = 256;

  /// The groups of the view's trees in which the batch should be traced. Nothing if OverflowMemory
  /// may have all of its trees in memory, or half of that for the trees that the rays enter first.
  /// The number of these is estimated from those that a sample enters once and twice [Chao1984]; no
  /// tree is read. Cost: constant for a small batch or scene, else linear in the trees. Throws
  /// std::bad_alloc.
  static std::optional<TreeGroups> of(const SceneView& view, const RayBatch& rays);

  std::size_t size() const { return groups_.size(); }
  /// The scene with the trees of one group; the others are empty. It is valid until the next call.
  /// Cost: linear in the trees of this group and of that before. Throws std::bad_alloc.
  SceneView show(std::size_t group);
  /// met[i], for rays [begin, end): bit g is set if the ray may meet a tree of group g within its
  /// limits. Throws std::bad_alloc.
  void find(const RayBatch& rays, std::size_t begin, std::size_t end, std::uint64_t* met) const;
  /// True if so many rays need so much of a group that reading all of it in order takes less time.
  bool is_worth_reading(std::size_t group, std::size_t rays) const;
  /// Reads a group into memory. release() unmaps it, with what other trees have in its pages.
  void read(std::size_t group) const;
  void release(std::size_t group) const;

 private:
  /// Whole pages in OverflowMemory.
  struct Range {
    const std::byte* begin = nullptr;
    std::size_t bytes = 0;
  };
  struct Group {
    std::vector<std::uint32_t> trees;  ///< indices in SceneTree::trees
    std::vector<Range> ranges;
    std::uint64_t bytes = 0;  ///< of `ranges`
  };
  explicit TreeGroups(const SceneView& view);
  double bytes_entered_first(const RayBatch& rays) const;
  void divide(std::uint64_t limit);
  void add(std::uint32_t tree, std::uint64_t bytes_most);

  const Scene* scene_;
  std::shared_ptr<const SceneTree> all_;
  std::shared_ptr<const WideTree> empty_;
  /// `all_` with its trees unbuilt, and empty where they are unbuilt: for UnbuiltTrees.
  std::shared_ptr<const SceneTree> missing_;
  std::shared_ptr<SceneTree> shown_;  ///< `all_` with empty trees, but for those of shown_group_
  std::size_t shown_group_ = 0;
  std::vector<Group> groups_;
  std::vector<std::uint8_t> group_of_;  ///< by index in SceneTree::trees
};

/// The closest hits of a batch in some trees after others. Several threads may use it for different
/// rays.
class ClosestOfGroups {
 public:
  /// Makes misses of all hits. All arguments must outlive the object.
  ClosestOfGroups(const Scene& scene, const RayBatch& rays, HitBatch& hits);
  /// The t beyond which a ray needs no tree: one step above that of its hit so far, which is
  /// rounded.
  double limit(std::size_t i) const;
  /// Replaces the hits of the rays `numbers` by those of `hits` that come before them in the order
  /// of (exact t, id).
  void add(const HitBatch& hits, std::span<const std::size_t> numbers) const;

 private:
  bool is_closer(const HitBatch& hits, std::size_t slot, std::size_t ray) const;
  const Scene& scene_;
  const RayBatch& rays_;
  HitBatch& hits_;
};

}  // namespace sightline

// Tests: tests/unit/run/tree_groups_test.cpp
