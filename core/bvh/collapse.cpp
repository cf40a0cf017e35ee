#include "core/bvh/collapse.h"

#include <algorithm>
#include <array>
#include <limits>

namespace sightline {

namespace {

float half_area(const BinaryNode& node) {
  const float x = node.upper[0] - node.lower[0];
  const float y = node.upper[1] - node.lower[1];
  const float z = node.upper[2] - node.lower[2];
  return x * y + y * z + z * x;
}

std::uint32_t block_count(const BinaryNode& leaf) { return (leaf.count + kLanes - 1) / kLanes; }

/// Children of one wide node as indices of binary nodes.
struct Children {
  std::array<std::uint32_t, kArity> index{};
  std::size_t count = 0;
};

class Collapser {
 public:
  Collapser(const BinaryTree& binary, const LeafWriter& write_leaf, WideTree& tree)
      : binary_(binary), write_leaf_(write_leaf), tree_(tree) {}

  /// Returns the reference to the subtree under binary node `root`.
  std::uint32_t emit(std::uint32_t root, std::uint32_t depth) {
    if (binary_[root].count != 0) return emit_leaf(binary_[root]);
    const Children children = open(root);
    const std::uint32_t granule = tree_.arena.take(sizeof(WideNode));
    WideNode& node = *reinterpret_cast<WideNode*>(tree_.arena.at(granule));
    ++tree_.node_count;
    tree_.depth = std::max(tree_.depth, depth);

    for (std::size_t i = 0; i < kArity; ++i) {
      const bool used = i < children.count;
      for (std::size_t k = 0; k < 3; ++k) {
        node.lower[k][i] = used ? binary_[children.index[i]].lower[k] : kInf;
        node.upper[k][i] = used ? binary_[children.index[i]].upper[k] : -kInf;
      }
      node.child[i] = ChildRef::kEmpty;
    }
    write_orders(children.count, node);

    // Leaves first, right behind their node; then the subtrees.
    for (std::size_t i = 0; i < children.count; ++i) {
      const BinaryNode& child = binary_[children.index[i]];
      if (child.count != 0) node.child[i] = emit_leaf(child);
    }
    for (std::size_t i = 0; i < children.count; ++i) {
      if (binary_[children.index[i]].count == 0) node.child[i] = emit(children.index[i], depth + 1);
    }
    return ChildRef::node(granule);
  }

 private:
  static constexpr float kInf = std::numeric_limits<float>::infinity();

  Children open(std::uint32_t root) const {
    Children children;
    children.index[children.count++] = root + 1;
    children.index[children.count++] = binary_[root].link;
    while (children.count < kArity) {
      std::size_t largest = kArity;
      float area = -1;
      for (std::size_t i = 0; i < children.count; ++i) {
        const BinaryNode& child = binary_[children.index[i]];
        if (child.count == 0 && half_area(child) > area) {
          area = half_area(child);
          largest = i;
        }
      }
      if (largest == kArity) break;
      const std::uint32_t opened = children.index[largest];
      children.index[largest] = opened + 1;
      children.index[children.count++] = binary_[opened].link;
    }
    return children;
  }

  std::uint32_t emit_leaf(const BinaryNode& leaf) {
    const std::uint32_t blocks = block_count(leaf);
    const std::uint32_t granule = tree_.arena.take(blocks * sizeof(LeafBlock));
    write_leaf_(leaf.link, leaf.count, reinterpret_cast<LeafBlock*>(tree_.arena.at(granule)));
    tree_.block_count += blocks;
    return ChildRef::leaf(granule, blocks);
  }

  /// Children sorted along the diagonal of each octant; opposite octants are each other's reverse.
  static void write_orders(std::size_t count, WideNode& node) {
    for (std::uint32_t octant = 0; octant < 4; ++octant) {
      std::array<float, kArity> key{};
      std::array<std::uint32_t, kArity> rank{};
      for (std::uint32_t i = 0; i < kArity; ++i) rank[i] = i;
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const float centroid = node.lower[k][i] + node.upper[k][i];
          key[i] += (octant >> k & 1u) != 0 ? -centroid : centroid;
        }
      }
      // Far to near; empty children stand last and are never hit.
      std::stable_sort(rank.begin(), rank.begin() + static_cast<std::ptrdiff_t>(count),
                       [&](std::uint32_t a, std::uint32_t b) { return key[a] > key[b]; });
      std::uint32_t forward = 0;
      std::uint32_t backward = 0;
      for (std::uint32_t i = 0; i < kArity; ++i) {
        forward |= rank[i] << (3 * i);
        const std::uint32_t mirrored = i < count ? rank[count - 1 - i] : rank[i];
        backward |= mirrored << (3 * i);
      }
      node.order[octant] = forward;
      node.order[7 - octant] = backward;
    }
  }

  const BinaryTree& binary_;
  const LeafWriter& write_leaf_;
  WideTree& tree_;
};

}  // namespace

WideTree collapse(const BinaryTree& binary, const LeafWriter& write_leaf) {
  WideTree tree;
  if (binary.empty()) return tree;
  // At worst every box has a leaf of its own and every node only two children.
  const std::size_t worst = std::size_t{binary.box_count} * (sizeof(LeafBlock) + sizeof(WideNode));
  tree.arena = Arena(worst + sizeof(WideNode));
  tree.root = Collapser(binary, write_leaf, tree).emit(0, 1);
  tree.arena.shrink_to_fit();
  return tree;
}

}  // namespace sightline
