/// How finished trees take the place of trees that were built on demand.

#include <algorithm>
#include <map>
#include <utility>

#include "core/bvh/lazy_layout.h"

namespace sightline {

namespace {

/// The slots of the triangles of a finished tree.
struct Covered {
  std::vector<std::uint32_t> slots;
  std::uint64_t triangles = 0;  ///< sum over the slots
};

/// True if all triangles of `runs` are among those of `ascending_runs`.
bool contains(std::span<const TriangleRun> ascending_runs, std::span<const TriangleRun> runs) {
  return std::all_of(runs.begin(), runs.end(), [&](const TriangleRun& run) {
    const auto after = std::upper_bound(
        ascending_runs.begin(), ascending_runs.end(), run.first,
        [](std::uint32_t first, const TriangleRun& other) { return first < other.first; });
    if (after == ascending_runs.begin()) return false;
    const TriangleRun& around = *std::prev(after);
    return run.first + std::uint64_t{run.count} <= around.first + std::uint64_t{around.count};
  });
}

/// For each finished tree the slots that it replaces; none if some of its triangles are elsewhere.
std::vector<Covered> find_covered(std::span<const FinishedTree> finished,
                                  const std::vector<TreeSlot>& slots) {
  std::multimap<std::pair<std::uint32_t, std::uint32_t>, std::size_t> by_place;
  for (std::size_t f = 0; f < finished.size(); ++f)
    by_place.emplace(std::pair{finished[f].mesh, finished[f].placement}, f);
  std::vector<Covered> covered(finished.size());
  for (std::uint32_t i = 0; i < slots.size(); ++i) {
    const TreeSlot& slot = slots[i];
    if (slot.entries == 0) continue;
    const auto [first, last] = by_place.equal_range({slot.mesh, slot.placement});
    for (auto at = first; at != last; ++at) {
      const std::span<const TriangleRun> runs = finished[at->second].part.runs;
      if (!runs.empty() && (slot.runs.empty() || !contains(runs, slot.runs))) continue;
      covered[at->second].slots.push_back(i);
      covered[at->second].triangles += slot.triangle_count;
    }
  }
  for (std::size_t f = 0; f < finished.size(); ++f) {
    const MeshPart& part = finished[f].part;
    if (!part.runs.empty() && covered[f].triangles != part.triangle_count) covered[f] = {};
  }
  return covered;
}

}  // namespace

SceneTree LazyLayout::replace(std::span<const FinishedTree> finished, const SceneTree& tree) {
  constexpr std::uint32_t kStays = 0xffffffffu;
  // The last entry stands for placements of several meshes.
  if (tree.placements.size() > tree.entries) return share(tree);
  const std::vector<Covered> covered = find_covered(finished, slots_);
  SceneTree next = share(tree);
  std::vector<TreeSlot> slots = slots_;
  std::vector<std::uint32_t> replacement(slots.size(), kStays);  // by the numbers of slots
  bool enters_anew = false;
  for (std::size_t f = 0; f < finished.size(); ++f) {
    const std::vector<std::uint32_t>& old = covered[f].slots;
    if (old.empty()) continue;
    const auto made =
        finished[f].tree->root == ChildRef::kEmpty ? make_empty_tree() : finished[f].tree;
    if (old.size() == 1) {
      next.trees[old[0]] = made;
      continue;
    }
    enters_anew = true;
    TreeSlot slot = slots[old[0]];
    slot.triangle_count = static_cast<std::uint32_t>(covered[f].triangles);
    slot.entries = 0;
    slot.whole = true;
    slot.box = {};
    slot.runs = finished[f].part.runs;
    slot.owner = finished[f].part.owner;
    for (const std::uint32_t i : old) {
      slot.box.include(slots[i].box);
      replacement[i] = static_cast<std::uint32_t>(slots.size());
      slots[i] = {};
      next.trees[i] = make_empty_tree();
    }
    slots.push_back(std::move(slot));
    next.trees.push_back(made);
  }
  if (enters_anew) {
    // One entry for each place of a new slot.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> entered;
    std::vector<Placement> placements;
    std::vector<Box3d> boxes;
    for (std::uint32_t i = 0; i < tree.entries; ++i) {
      Placement placement = tree.placements[i];
      if (const std::uint32_t slot = replacement[placement.tree]; slot != kStays) {
        const auto [at, is_new] = entered.try_emplace({slot, placement.instance}, boxes.size());
        if (!is_new) {
          boxes[at->second].include(boxes_[i]);
          continue;
        }
        placement.tree = slot;
        ++slots[slot].entries;
      }
      placements.push_back(placement);
      boxes.push_back(boxes_[i]);
    }
    std::swap(boxes_, boxes);
    try {
      place(std::move(placements), next);
    } catch (...) {
      std::swap(boxes_, boxes);
      throw;
    }
  }
  slots_ = std::move(slots);
  next.unbuilt_count =
      static_cast<std::uint32_t>(std::count(next.trees.begin(), next.trees.end(), next.unbuilt));
  std::uint32_t deepest = 0;
  for (const auto& each : next.trees) deepest = std::max(deepest, each->depth);
  next.depth = next.top.depth + deepest;
  return next;
}

}  // namespace sightline
