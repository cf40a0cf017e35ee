#include "core/trace/search/tree_groups.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/infinity.h"
#include "core/base/overflow_memory.h"
#include "core/base/pages.h"
#include "core/bvh/lazy_layout.h"
#include "core/geometry/exact_hit.h"
#include "core/trace/search/unbuilt.h"

namespace sightline {
namespace {

/// Bytes that are read from a disk one after the other in the time of the few pages that one ray
/// reads elsewhere.
constexpr std::uint64_t kBytesOfRay = 256 << 10;

}  // namespace

std::optional<TreeGroups> TreeGroups::of(const SceneView& view, const RayBatch& rays) {
  if (rays.size() < kSample) return std::nullopt;
  const SceneTrees& trees = view.scene().trees();
  const std::uint64_t all = trees.tree_bytes(), held = trees.held_tree_bytes();
  if (all <= held) return std::nullopt;
  const std::uint64_t limit = trees.overflow_limit();
  if (all - held <= limit) return std::nullopt;
  TreeGroups groups(view);
  if (groups.bytes_entered_first(rays) <= static_cast<double>(limit) / 2) return std::nullopt;
  groups.divide(limit);
  return groups;
}

TreeGroups::TreeGroups(const SceneView& view)
    : scene_(&view.scene()), all_(view.shared_tree()), empty_(make_empty_tree()) {
  SceneTree missing = share(*all_);
  missing.unbuilt = make_empty_tree();
  missing.unbuilt_count = 0;
  for (std::uint32_t i = 0; i < missing.trees.size(); ++i) {
    const bool is_there = !all_->is_unbuilt(i) && all_->trees[i]->block_count > 0;
    missing.trees[i] = is_there ? missing.unbuilt : empty_;
    missing.unbuilt_count += is_there ? 1u : 0u;
  }
  missing_ = std::make_shared<const SceneTree>(std::move(missing));
}

double TreeGroups::bytes_entered_first(const RayBatch& rays) const {
  const SceneView view(*scene_, missing_);
  UnbuiltTrees search(view);
  std::vector<std::uint16_t> entered(all_->trees.size());
  double enter = 0;
  for (std::size_t i = 0; i < kSample; ++i) {
    const std::size_t number = i * rays.size() / kSample;
    const std::uint32_t first = search.nearest(rays[number], rays.tmax[number]);
    if (first == kNone) continue;
    ++entered[first];
    ++enter;
  }
  double seen = 0, once = 0, twice = 0, bytes = 0;
  for (std::size_t i = 0; i < entered.size(); ++i) {
    if (entered[i] == 0) continue;
    ++seen;
    once += entered[i] == 1 ? 1 : 0;
    twice += entered[i] == 2 ? 1 : 0;
    if (all_->trees[i]->in_overflow) bytes += static_cast<double>(all_->trees[i]->arena.used());
  }
  if (seen == 0) return 0;
  const double trees = seen + once * (once - 1) / (2 * (twice + 1));
  const double most = enter * static_cast<double>(rays.size()) / kSample;
  return std::min(trees, most) * bytes / seen;
}

void TreeGroups::divide(std::uint64_t limit) {
  const auto tree = [&](std::uint32_t i) -> const WideTree& { return *all_->trees[i]; };
  std::vector<std::uint32_t> grouped;
  std::uint64_t all_bytes = 0;
  for (std::uint32_t i = 0; i < all_->trees.size(); ++i) {
    if (!missing_->is_unbuilt(i)) continue;
    grouped.push_back(i);
    if (tree(i).in_overflow) all_bytes += tree(i).arena.used();
  }
  std::sort(grouped.begin(), grouped.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (tree(a).in_overflow != tree(b).in_overflow) return tree(b).in_overflow;
    return std::less<>()(tree(a).arena.at(0), tree(b).arena.at(0));
  });
  // Two groups less: that of the other trees, and one for what does not fill a group.
  const std::uint64_t most = std::max(limit / kPartOfLimit, all_bytes / (kMost - 2) + 1);
  group_of_.assign(all_->trees.size(), 0);
  for (const std::uint32_t i : grouped) add(i, most);

  SceneTree shown = share(*all_);
  std::fill(shown.trees.begin(), shown.trees.end(), empty_);
  shown.unbuilt.reset();
  shown.unbuilt_count = 0;
  shown_ = std::make_shared<SceneTree>(std::move(shown));
}

void TreeGroups::add(std::uint32_t number, std::uint64_t bytes_most) {
  const WideTree& tree = *all_->trees[number];
  const bool continues = !groups_.empty() && tree.in_overflow != groups_.back().ranges.empty();
  const bool is_full = !groups_.empty() && groups_.back().bytes >= bytes_most;
  if ((!continues || is_full) && groups_.size() < kMost) groups_.emplace_back();
  Group& group = groups_.back();
  group.trees.push_back(number);
  group_of_[number] = static_cast<std::uint8_t>(groups_.size() - 1);
  if (!tree.in_overflow) return;
  // Small trees share pages, so the range begins and ends at pages.
  const std::byte* const at = tree.arena.at(0);
  const std::size_t before = reinterpret_cast<std::uintptr_t>(at) % whole_pages(1);
  const Range range{at - before, whole_pages(before + tree.arena.used())};
  if (!group.ranges.empty()) {
    Range& last = group.ranges.back();
    const auto distance = reinterpret_cast<std::uintptr_t>(range.begin) -
                          reinterpret_cast<std::uintptr_t>(last.begin);
    if (distance <= last.bytes) {
      const std::size_t bytes = std::max(last.bytes, distance + range.bytes);
      group.bytes += bytes - last.bytes;
      last.bytes = bytes;
      return;
    }
  }
  group.bytes += range.bytes;
  group.ranges.push_back(range);
}

SceneView TreeGroups::show(std::size_t group) {
  for (const std::uint32_t i : groups_[shown_group_].trees) shown_->trees[i] = empty_;
  for (const std::uint32_t i : groups_[group].trees) shown_->trees[i] = all_->trees[i];
  shown_group_ = group;
  return {*scene_, shown_};
}

void TreeGroups::find(const RayBatch& rays, std::size_t begin, std::size_t end,
                      std::uint64_t* met) const {
  const SceneView view(*scene_, missing_);
  UnbuiltTrees search(view);
  std::vector<std::uint32_t> trees;
  for (std::size_t i = begin; i < end; ++i) {
    trees.clear();
    search.met(rays[i], trees);
    met[i] = 0;
    for (const std::uint32_t tree : trees) met[i] |= std::uint64_t{1} << group_of_[tree];
  }
}

bool TreeGroups::is_worth_reading(std::size_t group, std::size_t rays) const {
  return groups_[group].bytes > 0 && groups_[group].bytes / kBytesOfRay <= rays;
}

void TreeGroups::read(std::size_t group) const {
  for (const Range& range : groups_[group].ranges) {
    OverflowMemory::map_pages(range.begin, range.bytes);
  }
}

void TreeGroups::release(std::size_t group) const {
  for (const Range& range : groups_[group].ranges) {
    OverflowMemory::unmap_pages(range.begin, range.bytes);
  }
}

ClosestOfGroups::ClosestOfGroups(const Scene& scene, const RayBatch& rays, HitBatch& hits)
    : scene_(scene), rays_(rays), hits_(hits) {
  std::fill(hits.t.begin(), hits.t.end(), kInf);
  std::fill(hits.instance.begin(), hits.instance.end(), kNone);
  std::fill(hits.triangle.begin(), hits.triangle.end(), kNone);
}

double ClosestOfGroups::limit(std::size_t i) const {
  if (!hits_.hit(i)) return rays_.tmax[i];
  return std::min(rays_.tmax[i], std::nextafter(hits_.t[i], kInf));
}

void ClosestOfGroups::add(const HitBatch& hits, std::span<const std::size_t> numbers) const {
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (is_closer(hits, k, numbers[k])) hits_.copy(hits, k, numbers[k]);
  }
}

bool ClosestOfGroups::is_closer(const HitBatch& hits, std::size_t slot, std::size_t ray) const {
  if (!hits.hit(slot) || !hits_.hit(ray)) return hits.hit(slot);
  if (hits.t[slot] != hits_.t[ray]) return hits.t[slot] < hits_.t[ray];
  const Ray of = rays_[ray];
  const auto exact = [&](TriangleId id) {
    ExactT t;
    exact_hit(of.origin, of.direction, of.tmin, of.tmax, scene_.world_triangle(id), t);
    return t;
  };
  const int order = compare(exact(hits.id(slot)), exact(hits_.id(ray)));
  return order != 0 ? order < 0 : hits.id(slot) < hits_.id(ray);
}

}  // namespace sightline
