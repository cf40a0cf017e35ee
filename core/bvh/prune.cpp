#include "core/bvh/prune.h"

#include <cstring>
#include <vector>

#include "core/geometry/rounding.h"

namespace sightline {

namespace {

/// The leaf with those of its blocks that stay; kEmpty without any.
std::uint32_t pruned_leaf(WideTree& tree, std::uint32_t ref,
                          const std::function<bool(std::uint32_t)>& gone) {
  auto* block = reinterpret_cast<LeafBlock*>(tree.arena.at(ChildRef::granule(ref)));
  LeafBlock* end = block;  // of the blocks that stay
  std::uint32_t left = 0;
  for (std::uint32_t i = 0; i < ChildRef::blocks(ref); ++i) {
    const std::uint32_t granules = block->granules();
    if (!gone(block->placement())) {
      if (end != block) std::memmove(end, block, std::size_t{granules} * Arena::kGranule);
      end += granules;
      ++left;
    }
    block += granules;
  }
  tree.block_count -= ChildRef::blocks(ref) - left;
  return left == 0 ? ChildRef::kEmpty : ChildRef::leaf(ChildRef::granule(ref), left);
}

}  // namespace

WideTree without_placements(const WideTree& tree, const std::function<bool(std::uint32_t)>& gone) {
  WideTree left;
  left.arena = Arena(tree.arena.used());
  left.arena.take(tree.arena.used());
  std::memcpy(left.arena.at(0), tree.arena.at(0), tree.arena.used());
  left.root = tree.root;
  left.scale_exponent = tree.scale_exponent;
  left.bounds = tree.bounds;
  left.node_count = tree.node_count;
  left.block_count = tree.block_count;
  left.depth = tree.depth;
  if (tree.root == ChildRef::kEmpty) return left;
  if (ChildRef::is_leaf(tree.root)) {
    left.root = pruned_leaf(left, tree.root, gone);
    return left;
  }
  std::vector<std::uint32_t> waiting{tree.root};
  while (!waiting.empty()) {
    auto& node = *reinterpret_cast<WideNode*>(left.arena.at(waiting.back()));
    waiting.pop_back();
    for (std::size_t i = 0; i < kArity; ++i) {
      std::uint32_t& child = node.child[i];
      if (child == ChildRef::kEmpty) continue;
      if (!ChildRef::is_leaf(child)) {
        waiting.push_back(child);
        continue;
      }
      child = pruned_leaf(left, child, gone);
      if (child != ChildRef::kEmpty) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        node.lower[k][i] = kInfF;
        node.upper[k][i] = -kInfF;
      }
    }
  }
  return left;
}

}  // namespace sightline
