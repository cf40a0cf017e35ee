#pragma once
/// WideTree: a bounding volume hierarchy with eight children per node, in one arena.
///
///     node (256 bytes)               leaf block (160 bytes), up to four in a row
///     lower x[8] y[8] z[8]           corners as columns: [corner][axis][lane], float32
///     upper x[8] y[8] z[8]           triangle[4]  edge_max  lane_count  placement
///     child[8]  order[8 octants]
///
/// Nodes and blocks are addressed by granules of 32 bytes from the arena's start. So a tree is
/// position independent and can be mapped from a file. Nodes begin at cache lines. A block touches
/// three cache lines, wherever it begins.

#include <cstdint>
#include <memory>

#include "core/base/arena.h"
#include "core/bvh/leaf_block.h"
#include "core/geometry/box3.h"

namespace sightline {

inline constexpr int kArity = 8;
inline constexpr std::size_t kNodeAlign = 64;
/// Leaf blocks in a leaf.
inline constexpr int kMaxLeafBlocks = 4;
/// The most nodes on a path from the root that a builder may make. The stacks of the kernels are
/// sized for it.
inline constexpr std::uint32_t kMaxTreeDepth = 130;

/// A reference to a child of a node: a node, a leaf of 1 to 4 blocks, or nothing (kEmpty). It is a
/// granule and, for a leaf, the number of blocks.
struct ChildRef {
  static constexpr std::uint32_t kLeafBit = 0x80000000u;
  static constexpr std::uint32_t kBlocksShift = 29;
  // a tree has at most 16 GiB
  static constexpr std::uint32_t kGranuleMask = (1u << kBlocksShift) - 1;
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  static std::uint32_t node(std::uint32_t granule) { return granule; }
  static std::uint32_t leaf(std::uint32_t granule, std::uint32_t blocks) {
    return kLeafBit | (blocks - 1) << kBlocksShift | granule;
  }
  static bool is_leaf(std::uint32_t ref) { return (ref & kLeafBit) != 0; }
  static std::uint32_t granule(std::uint32_t ref) { return ref & kGranuleMask; }
  static std::uint32_t blocks(std::uint32_t ref) { return ((ref >> kBlocksShift) & 3u) + 1; }
  /// A reference to the leaf without its first block. Precondition: it has more than one.
  static std::uint32_t rest(std::uint32_t ref) {
    return ref - (1u << kBlocksShift) + std::uint32_t{sizeof(LeafBlock) / Arena::kGranule};
  }
};

/// A node: the boxes of its eight children and references to them.
struct alignas(kNodeAlign) WideNode {
  /// Closed boxes of the children in tree units, rounded outwards. An empty child has lower = +inf,
  /// upper = -inf. The order of the children matters to any-hit queries, which visit the last child
  /// first.
  float lower[3][kArity];
  float upper[3][kArity];
  std::uint32_t child[kArity];
  /// For each octant of ray directions (bit k of the index is set if component k is negative): the
  /// children from far to near, three bits each, the farthest in the lowest bits [Fuetterling2015].
  std::uint32_t order[8];
};
static_assert(sizeof(WideNode) == 256);

/// Boxes are in tree units: scene units times 2^scale_exponent. The exponent is 0 unless
/// coordinates are so large or small that float32 boxes would lose precision.
struct WideTree {
  Arena arena;
  std::uint32_t root = ChildRef::kEmpty;  ///< kEmpty: nothing can be hit
  int scale_exponent = 0;
  Box3d bounds;  ///< bounds of the triangles in scene units (mesh units for a shared tree)
  std::uint32_t node_count = 0;
  std::uint32_t block_count = 0;
  std::uint32_t depth = 0;  ///< nodes on the longest path from the root

  /// Returns a tree that uses the memory of `tree` and retains it.
  static WideTree alias(const std::shared_ptr<const WideTree>& tree) {
    WideTree same;
    same.arena = Arena(tree->arena.at(0), tree->arena.used(), tree);
    same.root = tree->root;
    same.scale_exponent = tree->scale_exponent;
    same.bounds = tree->bounds;
    same.node_count = tree->node_count;
    same.block_count = tree->block_count;
    same.depth = tree->depth;
    return same;
  }
  const WideNode& node(std::uint32_t ref) const {
    return *reinterpret_cast<const WideNode*>(arena.at(ref));
  }
  /// The blocks of a leaf; `ref` has ChildRef::blocks(ref) of them.
  const LeafBlock* blocks(std::uint32_t ref) const {
    return reinterpret_cast<const LeafBlock*>(arena.at(ChildRef::granule(ref)));
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
