#include "core/bvh/wide_plan.h"

#include "core/base/parallel.h"

namespace sightline {

namespace {
constexpr std::uint32_t kNodeGranules = sizeof(WideNode) / Arena::kGranule;
constexpr std::uint32_t kBlockGranules = sizeof(LeafBlock) / Arena::kGranule;
}  // namespace

WidePlan::WidePlan(const BinaryTree& binary, const CollapseOptions& options)
    : binary_(binary), options_(options), choice_(binary.node_end), granules_(binary.node_end) {
  const float area = binary[0].half_area();
  memory_cost_ = options.memory_cost * area / static_cast<float>(binary.ids.size());
  const Forest root = solve(0);
  cost_ = area > 0 ? root.cost[0] / area : 0;
}

WidePlan::Forest WidePlan::solve(std::uint32_t index) {
  const BinaryNode& node = binary_[index];
  const float area = node.half_area();
  const std::uint32_t boxes = node.box_count();
  const bool is_small = node.is_leaf() || boxes <= options_.leaf_max;
  const std::uint32_t leaf_blocks = is_small ? blocks(index) : 0;
  const bool may_be_leaf = is_small && leaf_blocks <= kMaxLeafBlocks;
  const std::uint32_t leaf_granules = leaf_blocks * kBlockGranules;
  const float leaf_cost = options_.block_cost * static_cast<float>(leaf_blocks) * area +
                          memory_cost_ * static_cast<float>(leaf_granules);
  Forest forest;
  if (node.is_leaf()) {
    forest.cost.fill(leaf_cost);
    forest.granules.fill(leaf_granules);
    choice_[index] = kLeaf;
    granules_[index] = leaf_granules;
    return forest;
  }

  Forest left, right;
  if (boxes < kParallelBoxes) {
    left = solve(node.link);
    right = solve(node.link + 1);
  } else if (is_cancelled(options_.cancel)) {
    return forest;
  } else {
    parallel_invoke([&] { left = solve(node.link); }, [&] { right = solve(node.link + 1); });
  }

  // The cheapest ways to share out i roots between the two sides.
  std::uint32_t choice = 0;
  for (std::uint32_t roots = 2; roots <= kArity; ++roots) {
    std::uint32_t best = 1;
    float cost = left.cost[0] + right.cost[roots - 2];
    for (std::uint32_t k = 2; k < roots; ++k) {
      const float other = left.cost[k - 1] + right.cost[roots - k - 1];
      best = other < cost ? k : best;
      cost = other < cost ? other : cost;
    }
    forest.cost[roots - 1] = cost;
    forest.granules[roots - 1] = left.granules[best - 1] + right.granules[roots - best - 1];
    choice |= best << (3 * (roots - 2));
  }
  // One root is a node over eight, or a leaf.
  forest.cost[0] = forest.cost[kArity - 1] + options_.node_cost * area +
                   memory_cost_ * static_cast<float>(kNodeGranules);
  // The blocks behind the node may end within a cache line; the next node does not begin there.
  forest.granules[0] = whole_lines(forest.granules[kArity - 1] + kNodeGranules);
  if (may_be_leaf && leaf_cost <= forest.cost[0]) {
    forest.cost[0] = leaf_cost;
    forest.granules[0] = leaf_granules;
    choice |= kLeaf;
  }
  for (std::uint32_t roots = 2; roots < kArity; ++roots) {
    if (forest.cost[roots - 1] < forest.cost[roots - 2]) continue;
    forest.cost[roots - 1] = forest.cost[roots - 2];
    forest.granules[roots - 1] = forest.granules[roots - 2];
    choice &= ~(7u << (3 * (roots - 2)));
  }
  choice_[index] = choice;
  granules_[index] = forest.granules[0];
  return forest;
}

WideChildren WidePlan::children(std::uint32_t root) const {
  WideChildren children;
  const std::uint32_t left = from_left(root, kArity);
  gather(binary_[root].link, left, children);
  gather(binary_[root].link + 1, kArity - left, children);
  return children;
}

void WidePlan::gather(std::uint32_t node, std::uint32_t roots, WideChildren& children) const {
  if (binary_[node].is_leaf()) roots = 1;
  while (roots > 1 && from_left(node, roots) == 0) --roots;
  if (roots == 1) {
    children.index[children.count++] = node;
    return;
  }
  const std::uint32_t left = from_left(node, roots);
  gather(binary_[node].link, left, children);
  gather(binary_[node].link + 1, roots - left, children);
}

}  // namespace sightline
