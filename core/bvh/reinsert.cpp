#include "core/bvh/reinsert.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/base/parallel.h"
#include "core/bvh/wide_tree.h"

namespace sightline {

namespace {

Bounds bounds_of(const BinaryNode& node) {
  return {Float4::load(node.lower), Float4::load(node.upper)};
}

/// A subtree, the node beside which it should stand, and the surface that this saves.
struct Move {
  float gain = 0;
  std::uint32_t node = 0;
  std::uint32_t beside = 0;
};

/// The tree with the way up from every node. Siblings are (1, 2), (3, 4), ...
class Reinsertion {
 public:
  explicit Reinsertion(const BinaryTree& tree) {
    number(tree);
    refit();
  }

  /// One pass. Returns which part of the surface of all inner nodes it saved: none when cancelled.
  double improve(float share, const CancelFlag* cancel) {
    std::vector<Move> moves(choose(share));
    parallel_for((moves.size() + kSearches - 1) / kSearches, [&](std::size_t chunk) {
      if (is_cancelled(cancel)) return;
      const std::size_t end = std::min(moves.size(), (chunk + 1) * kSearches);
      for (std::size_t i = chunk * kSearches; i < end; ++i) moves[i] = search(moves[i].node);
    });
    if (is_cancelled(cancel)) return 0;
    std::erase_if(moves, [](const Move& move) { return !(move.gain > 0); });
    std::sort(moves.begin(), moves.end(), [](const Move& a, const Move& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.node < b.node;
    });

    const Column<BinaryNode> nodes = nodes_;
    const Column<std::uint32_t> parents = parents_;
    touched_.assign(nodes_.size(), false);
    for (const Move& move : moves) apply(move);
    const double before = surface_;
    if (refit()) return before > 0 ? 1 - surface_ / before : 0;
    // Too deep for a kernel's stack: the pass is taken back.
    nodes_ = nodes;
    parents_ = parents;
    refit();
    return 0;
  }

  void store(BinaryTree& tree) {
    // Leaves from left to right: the boxes below every node become one range again.
    Column<std::uint32_t> ids;
    ids.reserve(tree.ids.size());
    for (const std::uint32_t i : order_) {
      BinaryNode& node = nodes_[i];
      if (!node.is_leaf()) continue;
      const std::uint32_t* first = tree.ids.data() + node.link;
      node.link = static_cast<std::uint32_t>(ids.size());
      ids.insert(ids.end(), first, first + node.id_count());
    }
    tree.ids = std::move(ids);
    const std::size_t bytes = nodes_.size() * sizeof(BinaryNode);
    tree.nodes = Arena(bytes);
    tree.nodes.take(bytes);
    std::memcpy(tree.nodes.at(0), nodes_.data(), bytes);
    tree.node_end = static_cast<std::uint32_t>(nodes_.size());
  }

 private:
  static constexpr std::size_t kSearches = 256;

  std::uint32_t sibling(std::uint32_t node) const { return ((node - 1) ^ 1u) + 1; }

  /// Copies the nodes from the root down: their old numbers tell which thread was first.
  void number(const BinaryTree& tree) {
    nodes_.reserve(tree.node_end);
    nodes_.push_back(tree[0]);
    parents_.push_back(0);
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].is_leaf()) continue;
      const std::uint32_t children = nodes_[i].link;
      nodes_[i].link = static_cast<std::uint32_t>(nodes_.size());
      for (const std::uint32_t child : {children, children + 1}) {
        nodes_.push_back(tree[child]);
        parents_.push_back(i);
      }
    }
  }

  /// The nodes with the largest surface, but the root.
  std::vector<Move> choose(float share) const {
    std::vector<Move> chosen;
    for (std::uint32_t i = 1; i < nodes_.size(); ++i)
      chosen.push_back({nodes_[i].half_area(), i, 0});
    const auto count = static_cast<std::size_t>(static_cast<float>(chosen.size()) * share);
    const auto last = chosen.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(chosen.begin(), last, chosen.end(), [](const Move& a, const Move& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.node < b.node;
    });
    chosen.resize(count);
    return chosen;
  }

  /// Goes up from the node, and at each level down into the part of the tree beside the way.
  Move search(std::uint32_t node) const {
    const Bounds moved = bounds_of(nodes_[node]);
    const float moved_area = moved.half_area();
    Move best{0, node, 0};
    struct Visit {
      std::uint32_t node;
      float saved;
    };
    std::array<Visit, kMaxTreeDepth + 2> waiting;

    // What is saved so far: the parent itself, and what its ancestors shrink without the node.
    float saved = nodes_[parents_[node]].half_area();
    Bounds without;
    for (std::uint32_t pivot = node; pivot != 0; pivot = parents_[pivot]) {
      std::size_t size = 0;
      waiting[size++] = {sibling(pivot), saved};
      while (size > 0) {
        const Visit visit = waiting[--size];
        if (visit.saved - moved_area <= best.gain) continue;
        const BinaryNode& target = nodes_[visit.node];
        Bounds both = bounds_of(target);
        both.include(moved);
        const float area = both.half_area();
        if (visit.saved - area > best.gain) best = {visit.saved - area, node, visit.node};
        if (target.is_leaf()) continue;
        const float below = visit.saved - (area - target.half_area());
        if (below - moved_area <= best.gain) continue;
        waiting[size++] = {target.link, below};
        waiting[size++] = {target.link + 1, below};
      }
      without.include(bounds_of(nodes_[sibling(pivot)]));
      const std::uint32_t parent = parents_[pivot];
      if (pivot != node) saved += nodes_[parent].half_area() - without.half_area();
    }
    return best;
  }

  /// Takes the node out, lifts its sibling into their parent's place, and puts the pair that has
  /// become free below `beside`.
  void apply(const Move& move) {
    const std::uint32_t node = move.node, other = sibling(node), parent = parents_[node];
    const std::uint32_t beside = move.beside;
    for (const std::uint32_t i : {node, other, parent, beside}) {
      if (touched_[i]) return;
    }
    if (beside == other || beside == parent) return;
    // An earlier move may have brought the place below the node.
    for (std::uint32_t i = beside; i != 0; i = parents_[i]) {
      if (i == node) return;
    }
    for (const std::uint32_t i : {node, other, parent, beside}) touched_[i] = true;

    place(nodes_[other], parent);
    place(nodes_[beside], other);
    parents_[node] = parents_[other] = beside;
    nodes_[beside].link = std::min(node, other);
    nodes_[beside].mark = BinaryNode::kInner;
  }

  void place(const BinaryNode& node, std::uint32_t at) {
    nodes_[at] = node;
    if (node.is_leaf()) return;
    parents_[node.link] = parents_[node.link + 1] = at;
  }

  /// Bounds and counts of all inner nodes from what is below them. False if a node is too deep.
  bool refit() {
    order_.clear();
    order_.reserve(nodes_.size());
    struct Visit {
      std::uint32_t node, depth;
    };
    std::vector<Visit> waiting{{0, 1}};
    while (!waiting.empty()) {
      const Visit visit = waiting.back();
      waiting.pop_back();
      if (visit.depth > kMaxTreeDepth) return false;
      order_.push_back(visit.node);
      const BinaryNode& node = nodes_[visit.node];
      if (node.is_leaf()) continue;
      waiting.push_back({node.link + 1, visit.depth + 1});
      waiting.push_back({node.link, visit.depth + 1});
    }
    surface_ = 0;
    for (std::size_t i = order_.size(); i-- > 0;) {
      BinaryNode& node = nodes_[order_[i]];
      if (node.is_leaf()) continue;
      const BinaryNode& left = nodes_[node.link];
      const BinaryNode& right = nodes_[node.link + 1];
      for (int k = 0; k < 3; ++k) {
        node.lower[k] = std::min(left.lower[k], right.lower[k]);
        node.upper[k] = std::max(left.upper[k], right.upper[k]);
      }
      node.mark = BinaryNode::kInner | (left.id_count() + right.id_count());
      surface_ += static_cast<double>(node.half_area());
    }
    return true;
  }

  Column<BinaryNode> nodes_;
  Column<std::uint32_t> parents_;
  std::vector<std::uint32_t>
      order_;  ///< all nodes, each before what is below it, left before right
  std::vector<bool> touched_;
  double surface_ = 0;  ///< half of it, of all inner nodes
};

}  // namespace

void reinsert(BinaryTree& tree, const ReinsertOptions& options) {
  if (tree.empty() || is_cancelled(options.cancel)) return;
  Reinsertion reinsertion(tree);
  double gain = 1;
  for (int pass = 0; pass < options.passes && gain >= options.least_gain; ++pass) {
    gain = reinsertion.improve(pass == 0 ? options.share / 4 : options.share, options.cancel);
    if (is_cancelled(options.cancel)) return;
  }
  reinsertion.store(tree);
}

}  // namespace sightline
