#pragma once
/// A bounding volume hierarchy with eight children per node in one arena.
///
///     node (256 bytes)               leaf block (160 bytes), up to four in a row
///     lower x[8] y[8] z[8]           corners as columns: [corner][axis][lane], float32
///     upper x[8] y[8] z[8]           triangle[4]  edge_max  lane_count  placement
///     child[8]  order[8 octants]
///
/// Everything is addressed by granules of 32 bytes from the arena's start, so that a tree is
/// position independent and can be mapped from a file. Nodes begin on cache lines; a block touches
/// three, wherever it begins.

#include <cstdint>
#include <memory>

#include "core/base/arena.h"
#include "core/bvh/leaf_block.h"
#include "core/geometry/box3.h"

namespace sightline {

inline constexpr int kArity = 8;
inline constexpr std::size_t kNodeAlign = 64;
inline constexpr int kMaxLeafBlocks = 4;
/// Nodes on the longest way down that any builder may make; the stacks of the kernels count on it.
inline constexpr std::uint32_t kMaxTreeDepth = 130;

/// A reference to a child: a node, a leaf, or nothing.
struct ChildRef {
  static constexpr std::uint32_t kLeafBit = 0x80000000u;
  static constexpr std::uint32_t kBlocksShift = 29;
  static constexpr std::uint32_t kGranuleMask = (1u << kBlocksShift) - 1;  // 16 GiB
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  static std::uint32_t node(std::uint32_t granule) { return granule; }
  static std::uint32_t leaf(std::uint32_t granule, std::uint32_t blocks) {
    return kLeafBit | (blocks - 1) << kBlocksShift | granule;
  }
  static bool is_leaf(std::uint32_t ref) { return (ref & kLeafBit) != 0; }
  static std::uint32_t granule(std::uint32_t ref) { return ref & kGranuleMask; }
  static std::uint32_t blocks(std::uint32_t ref) { return ((ref >> kBlocksShift) & 3u) + 1; }
  /// The leaf without its first block. Precondition: there are more.
  static std::uint32_t rest(std::uint32_t ref) {
    return ref - (1u << kBlocksShift) + std::uint32_t{sizeof(LeafBlock) / Arena::kGranule};
  }
};

struct alignas(kNodeAlign) WideNode {
  /// Slots: an any-hit query visits the children from the last slot to the first. Closed boxes in
  /// tree units, rounded outwards. An empty child has lower = +inf, upper = -inf.
  float lower[3][kArity];
  float upper[3][kArity];
  std::uint32_t child[kArity];
  /// For each octant of ray directions (bit k set: component k is negative) the children from far
  /// to near, three bits each, the farthest lowest [Fuetterling2015].
  std::uint32_t order[8];
};
static_assert(sizeof(WideNode) == 256);

/// Tree units are scene units times 2^scale_exponent: 0 unless coordinates are so large or small
/// that float32 boxes would lose their precision.
struct WideTree {
  Arena arena;
  std::uint32_t root = ChildRef::kEmpty;  ///< kEmpty: nothing can be hit
  int scale_exponent = 0;
  Box3d bounds;  ///< of the triangles, scene units (mesh units for a shared tree)
  std::uint32_t node_count = 0;
  std::uint32_t block_count = 0;
  std::uint32_t depth = 0;  ///< nodes on the longest way down

  /// A tree over the memory that `tree` owns.
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
  const LeafBlock* blocks(std::uint32_t ref) const {
    return reinterpret_cast<const LeafBlock*>(arena.at(ChildRef::granule(ref)));
  }
};

}  // namespace sightline

// Tests: tests/unit/bvh/reinsert_test.cpp
