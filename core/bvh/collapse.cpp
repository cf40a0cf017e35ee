#include "core/bvh/collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/parallel.h"
#include "core/bvh/wide_plan.h"

namespace sightline {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

struct Counts {
  std::uint32_t nodes = 0;
  std::uint32_t blocks = 0;
  std::uint32_t depth = 0;

  void include(const Counts& below) {
    nodes += below.nodes;
    blocks += below.blocks;
    depth = std::max(depth, below.depth);
  }
};

class Emitter {
 public:
  Emitter(const BinaryTree& binary, const WidePlan& plan, const LeafContent& content,
          const CancelFlag* cancel, Arena& arena)
      : binary_(binary), plan_(plan), content_(content), cancel_(cancel), arena_(arena) {}

  /// Writes what was chosen below binary node `root` from `granule` on and says how to refer to it.
  std::uint32_t emit(std::uint32_t root, std::uint32_t granule, Counts& counts) {
    if (plan_.is_leaf(root)) return emit_leaf(root, granule, counts);
    WideChildren children = plan_.children(root);
    sort_by_yield(children);
    WideNode& node = *reinterpret_cast<WideNode*>(arena_.at(granule));
    write_boxes(children, node);
    write_orders(children.count, node);

    // Leaves first, right behind their node; then the subtrees.
    std::uint32_t next = granule + std::uint32_t{sizeof(WideNode) / Arena::kGranule};
    std::array<std::uint32_t, kArity> place{};
    for (const bool leaves : {true, false}) {
      for (std::size_t i = 0; i < children.count; ++i) {
        if (plan_.is_leaf(children.index[i]) != leaves) continue;
        place[i] = next;
        next += plan_.granules(children.index[i]);
      }
      next = whole_lines(next);
    }
    std::array<Counts, kArity> below;
    const auto emit_child = [&](std::size_t i) {
      node.child[i] = emit(children.index[i], place[i], below[i]);
    };
    if (binary_[root].id_count() < kParallelBoxes) {
      for (std::size_t i = 0; i < children.count; ++i) emit_child(i);
    } else if (!is_cancelled(cancel_)) {
      parallel_for(children.count, emit_child);
    }
    for (const Counts& one : below) counts.include(one);
    ++counts.nodes;
    ++counts.depth;
    return ChildRef::node(granule);
  }

 private:
  std::uint32_t emit_leaf(std::uint32_t root, std::uint32_t granule, Counts& counts) {
    auto* first = reinterpret_cast<LeafBlock*>(arena_.at(granule));
    const LeafBlock* const end = write_blocks(root, first);
    std::uint32_t blocks = 0;
    for (const LeafBlock* block = first; block != end; block = block->next()) ++blocks;
    counts.blocks += blocks;
    return ChildRef::leaf(granule, blocks);
  }

  LeafBlock* write_blocks(std::uint32_t root, LeafBlock* to) const {
    if (!plan_.has_blocks_of_children(root))
      return content_.write(plan_.first_id(root), binary_[root].id_count(), to);
    return write_blocks(binary_[root].link + 1, write_blocks(binary_[root].link, to));
  }

  /// Last comes what promises a hit for the least work, for queries to which any hit will do: a
  /// large box over few triangles, a wall before a heap of furniture (docs/decisions/0012).
  void sort_by_yield(WideChildren& children) const {
    std::array<std::pair<float, std::uint32_t>, kArity> keyed;
    for (std::size_t i = 0; i < children.count; ++i) {
      const BinaryNode& child = binary_[children.index[i]];
      const float yield = child.half_area() / std::sqrt(static_cast<float>(child.id_count()));
      // Areas may overflow; NaN would confuse the sorting.
      keyed[i] = {yield >= 0 ? yield : 0.0f, children.index[i]};
    }
    std::sort(keyed.begin(), keyed.begin() + static_cast<std::ptrdiff_t>(children.count));
    for (std::size_t i = 0; i < children.count; ++i) children.index[i] = keyed[i].second;
  }

  void write_boxes(const WideChildren& children, WideNode& node) const {
    for (std::size_t i = 0; i < kArity; ++i) {
      const bool used = i < children.count;
      for (std::size_t k = 0; k < 3; ++k) {
        node.lower[k][i] = used ? binary_[children.index[i]].lower[k] : kInf;
        node.upper[k][i] = used ? binary_[children.index[i]].upper[k] : -kInf;
      }
      node.child[i] = ChildRef::kEmpty;
    }
  }

  /// Children sorted along the diagonal of each octant; opposite octants are each other's reverse.
  static void write_orders(std::size_t count, WideNode& node) {
    // Vectors of g++ and clang (docs/decisions/0029): branches on comparisons of positions are not
    // predicted.
    using Numbers = float __attribute__((vector_size(4 * kArity)));
    using Ranks = int __attribute__((vector_size(4 * kArity)));
    Numbers centroid[3];
    for (std::size_t k = 0; k < 3; ++k) {
      Numbers lower, upper;
      std::memcpy(&lower, node.lower[k], sizeof lower);
      std::memcpy(&upper, node.upper[k], sizeof upper);
      centroid[k] = lower + upper;
    }
    for (std::uint32_t octant = 0; octant < 4; ++octant) {
      Numbers key{};
      for (std::size_t k = 0; k < 3; ++k)
        key += (octant >> k & 1u) != 0 ? -centroid[k] : centroid[k];
      // The rank of a child is the number of those before it: far to near, then by number.
      const Ranks number{0, 1, 2, 3, 4, 5, 6, 7};
      Ranks before{};
      for (std::size_t j = 0; j < count; ++j) {
        const Numbers other = key[j] - Numbers{};
        before -= (other > key) | ((other == key) & (number > static_cast<int>(j)));
      }
      // Empty children stand last and are never hit.
      std::uint32_t forward = 0;
      std::uint32_t backward = 0;
      for (std::uint32_t i = 0; i < kArity; ++i) {
        const std::uint32_t rank = i < count ? static_cast<std::uint32_t>(before[i]) : i;
        forward |= i << (3 * rank);
        const auto mirrored = static_cast<std::uint32_t>(i < count ? count - 1 - rank : rank);
        backward |= i << (3 * mirrored);
      }
      node.order[octant] = forward;
      node.order[7 - octant] = backward;
    }
  }

  const BinaryTree& binary_;
  const WidePlan& plan_;
  const LeafContent& content_;
  const CancelFlag* cancel_;
  Arena& arena_;
};

}  // namespace

WideTree collapse(const BinaryTree& binary, const CollapseOptions& options,
                  const LeafContent& content) {
  WideTree tree;
  if (binary.empty()) return tree;
  const WidePlan plan(binary, options, content);
  if (is_cancelled(options.cancel)) return tree;
  // An empty cache line follows, because kernels read a few bytes behind the last block (LeafBlock).
  const std::size_t bytes =
      std::size_t{whole_lines(plan.granules(0))} * Arena::kGranule + kNodeAlign;
  tree.arena = Arena(bytes);
  tree.arena.take(bytes);
  Counts counts;
  tree.root = Emitter(binary, plan, content, options.cancel, tree.arena).emit(0, 0, counts);
  if (is_cancelled(options.cancel)) return {};
  tree.node_count = counts.nodes;
  tree.block_count = counts.blocks;
  tree.depth = counts.depth;
  return tree;
}

}  // namespace sightline
