#include "core/bvh/binary_tree.h"

#include <atomic>
#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/bvh/histogram.h"
#include "core/bvh/sweep.h"

namespace sightline {

namespace {

constexpr std::uint32_t kParallelBinning = 1u << 17;
constexpr std::uint32_t kParallelSubtrees = 1u << 12;

/// More bins where many triangles are cut: a bad place costs much there, and bins cost little.
std::size_t bins_for(std::uint32_t triangles) {
  return triangles < 64 ? 8 : triangles < 2048 ? 16 : Histogram::kMaxBins;
}

/// A range of boxes on its way to be a node.
struct Range {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::uint32_t first_triangle = 0;  ///< the triangles of the boxes before it
  std::uint32_t triangles = 0;
  RangeBounds bounds;
};

class Builder {
 public:
  /// Builds the nodes and ids of `tree`, whose arena has room for all nodes.
  Builder(Column<BuildBox>& boxes, const BinaryOptions& options, BinaryTree& tree)
      : boxes_(boxes), options_(options), tree_(tree) {}

  void run() {
    const auto count = static_cast<std::uint32_t>(boxes_.size());
    Total total;
    gather(0, count, total, [](Total& sum, std::span<const BuildBox> boxes) {
      for (const BuildBox& box : boxes) sum.include(box);
    });
    tree_.ids.resize(total.triangles);
    build_parallel(0, {0, count, 0, total.triangles, total.bounds}, 0);
    tree_.node_end = next_;
  }

 private:
  struct Total {
    RangeBounds bounds;
    std::uint32_t triangles = 0;

    void include(const BuildBox& box) {
      bounds.include(box);
      triangles += box.count;
    }
    void include(const Total& other) {
      bounds.include(other.bounds);
      triangles += other.triangles;
    }
  };
  /// Nodes that one thread may give away: taken from the common store a handful at a time, because
  /// most of the 2n - 2 that n boxes could need never are.
  struct Pool {
    std::uint32_t next = 0;
    std::uint32_t end = 0;
    std::uint32_t needed;  ///< at most so many more
  };

  void build_parallel(std::uint32_t slot, const Range& range, std::uint32_t depth) {
    if (is_cancelled(options_.cancel)) return;
    if (range.count < kParallelSubtrees) {
      Pool pool{0, 0, 2 * range.count - 2};
      build(slot, range, depth, pool);
      return;
    }
    Range left, right;
    divide(range, depth, left, right);
    const std::uint32_t children = next_.fetch_add(2);
    store_inner(slot, range, children);
    parallel_invoke([&] { build_parallel(children, left, depth + 1); },
                    [&] { build_parallel(children + 1, right, depth + 1); });
  }

  void build(std::uint32_t slot, const Range& range, std::uint32_t depth, Pool& pool) {
    if (range.triangles <= options_.leaf_max || range.count == 1) {
      store(slot, range, range.first_triangle, range.triangles);
      std::uint32_t* to = &tree_.ids[range.first_triangle];
      for (std::uint32_t i = 0; i < range.count; ++i) {
        const BuildBox& box = boxes_[range.first + i];
        for (std::uint32_t id = box.id; id < box.id + box.count; ++id) *to++ = id;
      }
      return;
    }
    Range left, right;
    divide(range, depth, left, right);
    const std::uint32_t children = take_pair(pool);
    store_inner(slot, range, children);
    build(children, left, depth + 1, pool);
    build(children + 1, right, depth + 1, pool);
  }

  std::uint32_t take_pair(Pool& pool) {
    if (pool.next == pool.end) {
      const std::uint32_t taken = std::min(pool.needed, 64u);
      pool.needed -= taken;
      pool.next = next_.fetch_add(taken);
      pool.end = pool.next + taken;
    }
    return std::exchange(pool.next, pool.next + 2);
  }

  void store_inner(std::uint32_t slot, const Range& range, std::uint32_t children) {
    store(slot, range, children, BinaryNode::kInner | range.triangles);
  }
  void store(std::uint32_t slot, const Range& range, std::uint32_t link, std::uint32_t mark) {
    BinaryNode& node = tree_[slot];
    range.bounds.boxes.lower.store(node.lower);
    range.bounds.boxes.upper.store(node.upper);
    node.link = link;
    node.mark = mark;
  }

  /// Adds boxes [first, first + count) to `sum`, which is empty. Merging is exact, so any division
  /// of labour gives the same.
  template <class Value, class Add>
  void gather(std::uint32_t first, std::uint32_t count, Value& sum, Add add) const {
    const std::span<const BuildBox> boxes(&boxes_[first], count);
    if (count < kParallelBinning) {
      add(sum, boxes);
      return;
    }
    sum = parallel_reduce(
        std::size_t{0}, boxes.size(), kParallelBinning / 8, sum,
        [&](std::size_t begin, std::size_t end, Value value) {
          add(value, boxes.subspan(begin, end - begin));
          return value;
        },
        [](Value a, const Value& b) {
          a.include(b);
          return a;
        });
  }

  /// Sorts the boxes of a range into two.
  void divide(const Range& range, std::uint32_t depth, Range& left, Range& right) {
    left.first = range.first;
    left.first_triangle = range.first_triangle;
    left.count = range.count / 2;
    if (depth < options_.max_depth) {
      if (range.count <= Sweep::kMax) {
        left.count = Sweep::cut(&boxes_[range.first], range.count, options_.block_size).place;
      } else if (divide_by_bins(range, left, right)) {
        return;
      }
    }
    right.first = left.first + left.count;
    right.count = range.count - left.count;
    for (Range* side : {&left, &right}) {
      for (std::uint32_t i = 0; i < side->count; ++i) {
        side->bounds.include(boxes_[side->first + i]);
        side->triangles += boxes_[side->first + i].count;
      }
    }
    right.first_triangle = left.first_triangle + left.triangles;
  }

  /// False if the centroids are too close to tell apart.
  bool divide_by_bins(const Range& range, Range& left, Range& right) {
    const std::size_t bins = bins_for(range.triangles);
    const Binning binning(range.bounds.middles, bins);
    Histogram histogram(bins);
    gather(range.first, range.count, histogram,
           [&](Histogram& sum, std::span<const BuildBox> boxes) { sum.add(binning, boxes); });
    const Split split = histogram.best(options_.block_size);
    if (split.cost == std::numeric_limits<float>::infinity()) return false;

    left.bounds.boxes = histogram.bounds(split.axis, 0, split.place);
    right.bounds.boxes = histogram.bounds(split.axis, split.place, bins);
    left.triangles = histogram.count(split.axis, 0, split.place);
    right.triangles = range.triangles - left.triangles;
    right.first_triangle = range.first_triangle + left.triangles;
    const auto place = static_cast<float>(split.place);
    switch (split.axis) {
      case 0:
        partition<0>(range, binning, place, left, right);
        break;
      case 1:
        partition<1>(range, binning, place, left, right);
        break;
      default:
        partition<2>(range, binning, place, left, right);
    }
    return true;
  }

  /// Without branches: which side a box falls to cannot be predicted.
  template <int kAxis>
  void partition(const Range& range, const Binning& binning, float place, Range& left,
                 Range& right) {
    const Float4 cut = Float4::all(place);
    Bounds left_middles, right_middles;
    BuildBox* to = &boxes_[range.first];
    BuildBox* const end = to + range.count;
    for (BuildBox* box = to; box != end; ++box) {
      const Float4 middle = box->middle();
      const Mask4 goes_left = binning.is_below<kAxis>(middle, cut);
      left_middles.include_numbers(nan_if(!goes_left, middle));
      right_middles.include_numbers(nan_if(goes_left, middle));
      swap(*box, *to);
      to += goes_left.first() ? 1 : 0;
    }
    left.bounds.middles = left_middles;
    right.bounds.middles = right_middles;
    left.count = static_cast<std::uint32_t>(to - &boxes_[range.first]);
    right.first = range.first + left.count;
    right.count = range.count - left.count;
  }

  Column<BuildBox>& boxes_;
  const BinaryOptions& options_;
  BinaryTree& tree_;
  std::atomic<std::uint32_t> next_{1};
};

}  // namespace

BinaryTree build_binary_tree(Column<BuildBox> boxes, const BinaryOptions& options) {
  BinaryTree tree;
  if (boxes.empty()) return tree;
  const std::size_t bytes = 2 * boxes.size() * sizeof(BinaryNode);
  tree.nodes = Arena(bytes);
  tree.nodes.take(bytes);
  Builder(boxes, options, tree).run();
  if (is_cancelled(options.cancel)) return {};
  return tree;
}

}  // namespace sightline
