#include "core/bvh/wide_plan.h"

#include "core/base/parallel.h"

namespace sightline {

namespace {
constexpr std::uint32_t kNodeGranules = sizeof(WideNode) / Arena::kGranule;
}  // namespace

WidePlan::WidePlan(const BinaryTree& binary, const CollapseOptions& options,
                   const LeafContent& content)
    : binary_(binary),
      options_(options),
      content_(content),
      choice_(binary.node_end),
      granules_(binary.node_end) {
  const float area = binary[0].half_area();
  memory_cost_ = options.memory_cost * area / static_cast<float>(binary.ids.size());
  const Forest root = solve(0);
  cost_ = area > 0 ? root.cost[0] / area : 0;
}

WidePlan::Forest WidePlan::solve(std::uint32_t index) {
  const BinaryNode& node = binary_[index];
  const float area = node.half_area();
  const std::uint32_t boxes = node.id_count();
  const auto cost_of = [&](const LeafSize& leaf) {
    return options_.block_cost * static_cast<float>(leaf.blocks) * area +
           memory_cost_ * static_cast<float>(leaf.granules);
  };
  Forest forest;
  if (node.is_leaf()) {
    forest.leaf = leaf_size(index);
    forest.cost.fill(cost_of(forest.leaf));
    forest.granules.fill(forest.leaf.granules);
    choice_[index] = kLeaf;
    granules_[index] = forest.leaf.granules;
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
  if (boxes <= options_.leaf_max) {
    forest.leaf = {left.leaf.blocks + right.leaf.blocks, left.leaf.granules + right.leaf.granules};
    if (forest.leaf.blocks > (boxes + options_.block - 1) / options_.block) {
      forest.leaf = leaf_size(index);
    } else {
      choice |= kBlocksOfChildren;
    }
    const float cost = cost_of(forest.leaf);
    if (forest.leaf.blocks <= kMaxLeafBlocks && cost <= forest.cost[0]) {
      forest.cost[0] = cost;
      forest.granules[0] = forest.leaf.granules;
      choice |= kLeaf;
    }
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
