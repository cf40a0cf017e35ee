#pragma once
/// WideTree: a bounding volume hierarchy with eight children per node, in one arena. build_top,
/// build_triangle_tree and collapse make trees; the kernels of core/trace traverse them.
///
///     node (256 bytes)               leaf block (96 to 160 bytes), up to four in a leaf
///     lower x[8] y[8] z[8]           triangle[4]  edge_max  lane_count  placement
///     upper x[8] y[8] z[8]           vertices as columns, float32: x[] y[] z[]
///     child[8]  order[8 octants]     the vertices of the corners
///
/// Nodes and blocks are addressed by granules (Arena::kGranule), units of 32 bytes from the arena's
/// start. So a tree is position independent and can be mapped from a file. Nodes begin at cache
/// lines. A block of 96 bytes touches two cache lines, wherever it begins.

#include <cstdint>
#include <memory>

#include "core/base/arena.h"
#include "core/bvh/leaf_block.h"
#include "core/geometry/box3.h"

namespace sightline {

/// Children of a node.
inline constexpr int kArity = 8;
/// Alignment of nodes in bytes: a cache line.
inline constexpr std::size_t kNodeAlign = 64;
/// The most leaf blocks in a leaf.
inline constexpr int kMaxLeafBlocks = 4;
/// The most nodes on a path from the root that a builder may make. The stacks of the kernels are
/// sized for it.
inline constexpr std::uint32_t kMaxTreeDepth = 130;

/// A reference to a child of a node: a node, a leaf of 1 to 4 blocks, or kEmpty, which is no child.
/// A reference holds a granule and, for a leaf, the number of blocks. Functions that take a
/// reference must not get kEmpty: is_leaf() would be true.
struct ChildRef {
  /// The bit of a leaf, and the shift of its number of blocks less 1. The other bits are the
  /// granule.
  static constexpr std::uint32_t kLeafBit = 0x80000000u;
  static constexpr std::uint32_t kBlocksShift = 29;
  /// A tree has at most 2^29 granules, 16 GiB.
  static constexpr std::uint32_t kGranuleMask = (1u << kBlocksShift) - 1;
  /// The reference of an unused child, and the root of a tree without triangles.
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  /// Makes a reference to the node at a granule.
  static std::uint32_t node(std::uint32_t granule) { return granule; }
  /// Makes a reference to a leaf of `blocks` blocks, 1 to 4, of which the first is at a granule.
  static std::uint32_t leaf(std::uint32_t granule, std::uint32_t blocks) {
    return kLeafBit | (blocks - 1) << kBlocksShift | granule;
  }
  /// True for a leaf, false for a node.
  static bool is_leaf(std::uint32_t ref) { return (ref & kLeafBit) != 0; }
  /// The granule of a node, or of the first block of a leaf.
  static std::uint32_t granule(std::uint32_t ref) { return ref & kGranuleMask; }
  /// The number of blocks of a leaf.
  static std::uint32_t blocks(std::uint32_t ref) { return ((ref >> kBlocksShift) & 3u) + 1; }
  /// A reference to the leaf without its first block, which takes `granules`. Precondition: it has
  /// more than one.
  static std::uint32_t rest(std::uint32_t ref, std::uint32_t granules) {
    return ref - (1u << kBlocksShift) + granules;
  }
};

/// The blocks of a leaf, 1 to 4, for range-based loops.
class LeafBlocks {
 public:
  class Iterator {
   public:
    Iterator(const LeafBlock* at, std::uint32_t left) : at_(at), left_(left) {}
    const LeafBlock& operator*() const { return *at_; }
    Iterator& operator++() {
      at_ = at_->next();
      --left_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return left_ == other.left_; }

   private:
    const LeafBlock* at_;
    std::uint32_t left_;  ///< blocks from at_ on
  };

  /// Refers to `count` blocks, one behind the other.
  LeafBlocks(const LeafBlock* first, std::uint32_t count) : first_(first), count_(count) {}
  Iterator begin() const { return {first_, count_}; }
  Iterator end() const { return {nullptr, 0}; }
  const LeafBlock& front() const { return *first_; }
  std::uint32_t size() const { return count_; }

 private:
  const LeafBlock* first_;
  std::uint32_t count_;
};
static_assert(sizeof(LeafBlock) == Arena::kGranule);

/// A node: the boxes of its eight children and references to them.
struct alignas(kNodeAlign) WideNode {
  /// Closed boxes of the children in tree units, rounded outwards, as [axis][child]. An empty child
  /// has lower = +inf, upper = -inf. Any-hit queries visit the last child first, so builders put
  /// the child there that most likely gives a hit.
  float lower[3][kArity];
  float upper[3][kArity];
  /// References (ChildRef) to the children; kEmpty for unused ones.
  std::uint32_t child[kArity];
  /// For each octant of ray directions (bit k of the index is set if component k is negative): the
  /// children from far to near, three bits each, the farthest in the lowest bits [Fuetterling2015].
  std::uint32_t order[8];
};
static_assert(sizeof(WideNode) == 256);

/// A tree and its figures. Boxes are in tree units: coordinates of the space of the tree (the world
/// or a mesh) times 2^scale_exponent. The exponent is 0 unless coordinates are so large or small
/// that float32 boxes would lose precision.
struct WideTree {
  Arena arena;
  std::uint32_t root = ChildRef::kEmpty;  ///< a node, a leaf, or kEmpty: nothing can be hit
  int scale_exponent = 0;
  Box3d bounds;  ///< bounds of the triangles in the space of the tree, without the scale
  std::uint32_t node_count = 0;
  std::uint32_t block_count = 0;
  std::uint32_t depth = 0;   ///< nodes on the longest path from the root
  bool in_overflow = false;  ///< the arena is in OverflowMemory

  /// Returns a tree that uses the memory of `tree` and shares its ownership. Precondition: not
  /// null.
  static WideTree alias(const std::shared_ptr<const WideTree>& tree) {
    WideTree same;
    same.arena = Arena(tree->arena.at(0), tree->arena.used(), tree);
    same.root = tree->root;
    same.scale_exponent = tree->scale_exponent;
    same.bounds = tree->bounds;
    same.node_count = tree->node_count;
    same.block_count = tree->block_count;
    same.depth = tree->depth;
    same.in_overflow = tree->in_overflow;
    return same;
  }
  /// The node of a reference. Precondition: the reference is a node, not a leaf or kEmpty.
  const WideNode& node(std::uint32_t ref) const {
    return *reinterpret_cast<const WideNode*>(arena.at(ref));
  }
  /// The blocks of a leaf. Precondition: the reference is a leaf.
  LeafBlocks blocks(std::uint32_t ref) const {
    return {reinterpret_cast<const LeafBlock*>(arena.at(ChildRef::granule(ref))),
            ChildRef::blocks(ref)};
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/validate_test.cpp
