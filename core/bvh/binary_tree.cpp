#include "core/bvh/binary_tree.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/parallel.h"
#include "core/bvh/float4.h"

namespace sightline {

namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kParallelBinning = 1u << 17;
constexpr std::uint32_t kParallelSubtrees = 1u << 12;
constexpr float kInf = std::numeric_limits<float>::infinity();

/// Bounds whose fourth lane carries rubbish (an id reinterpreted) and is never looked at.
struct Bounds {
  Float4 lower = Float4::all(kInf);
  Float4 upper = Float4::all(-kInf);

  void include(Float4 low, Float4 high) {
    lower = min(lower, low);
    upper = max(upper, high);
  }
  void include(const Bounds& other) { include(other.lower, other.upper); }
  float half_area() const {
    alignas(16) std::array<float, 4> size;
    (upper - lower).store(size.data());
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }
};

Float4 lower_of(const BuildBox& box) { return Float4::load(box.lower); }
Float4 upper_of(const BuildBox& box) { return Float4::load(box.upper); }

/// Of a range: its bounds and the bounds of its doubled centroids (lower + upper).
struct RangeBounds {
  Bounds boxes;
  Bounds centroids;

  void include(const BuildBox& box) {
    const Float4 low = lower_of(box);
    const Float4 high = upper_of(box);
    boxes.include(low, high);
    const Float4 centroid = low + high;
    centroids.include(centroid, centroid);
  }
  void include(const RangeBounds& other) {
    boxes.include(other.boxes);
    centroids.include(other.centroids);
  }
};

/// Where a centroid falls: bin = (centroid - origin) * scale, per axis.
struct Binning {
  Float4 origin;
  Float4 scale;

  explicit Binning(const Bounds& centroids) : origin(centroids.lower), scale(Float4::all(0)) {
    alignas(16) std::array<float, 4> size;
    (centroids.upper - centroids.lower).store(size.data());
    for (float& s : size) s = s > 0 ? static_cast<float>(kBins) * 0.9999f / s : 0;
    scale = Float4::load(size.data());
  }
  void bins_of(const BuildBox& box, std::array<int, 4>& bins) const {
    ((lower_of(box) + upper_of(box) - origin) * scale).truncate(bins);
    // An extent so small that the scale overflowed gives NaN: everything lands in one bin.
    for (int& bin : bins) bin = std::clamp(bin, 0, static_cast<int>(kBins) - 1);
  }
};

struct Histogram {
  std::array<std::array<Bounds, kBins>, 3> bounds;
  std::array<std::array<std::uint32_t, kBins>, 3> counts{};

  void add(const Binning& binning, const BuildBox& box) {
    std::array<int, 4> bins;
    binning.bins_of(box, bins);
    const Float4 low = lower_of(box);
    const Float4 high = upper_of(box);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto bin = static_cast<std::size_t>(bins[axis]);
      bounds[axis][bin].include(low, high);
      ++counts[axis][bin];
    }
  }
  void include(const Histogram& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t bin = 0; bin < kBins; ++bin) {
        bounds[axis][bin].include(other.bounds[axis][bin]);
        counts[axis][bin] += other.counts[axis][bin];
      }
    }
  }
};

struct Split {
  float cost = kInf;
  std::size_t axis = 0;
  int bin = 0;  ///< boxes in bins below it go left
};

class Builder {
 public:
  Builder(Column<BuildBox>& boxes, const BinaryOptions& options, BinaryNode* nodes)
      : boxes_(boxes), options_(options), nodes_(nodes) {}

  void build(std::uint32_t slot, std::uint32_t first, std::uint32_t count, std::uint32_t depth) {
    const RangeBounds range = bounds_of(first, count);
    BinaryNode& node = nodes_[slot];
    store(range.boxes, node);

    std::uint32_t left = 0;
    if (!choose_split(range, first, count, depth, left)) {
      node.link = first;
      node.count = count;
      return;
    }
    node.count = 0;
    node.link = slot + 2 * left;
    const auto build_left = [&] { build(slot + 1, first, left, depth + 1); };
    const auto build_right = [&] { build(slot + 2 * left, first + left, count - left, depth + 1); };
    if (count >= kParallelSubtrees) {
      parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
  }

 private:
  static void store(const Bounds& bounds, BinaryNode& node) {
    bounds.lower.store(node.lower);
    bounds.upper.store(node.upper);
  }

  /// Over boxes [first, first + count): merging is exact, so any division of labour gives the same.
  template <class Value, class Add>
  Value reduce(std::uint32_t first, std::uint32_t count, const Value& empty, Add add) const {
    const auto serial = [&](std::size_t begin, std::size_t end, Value value) {
      for (std::size_t i = begin; i < end; ++i) add(value, boxes_[i]);
      return value;
    };
    const std::size_t end = std::size_t{first} + count;
    if (count < kParallelBinning) return serial(first, end, empty);
    return parallel_reduce(first, end, kParallelBinning / 8, empty, serial,
                           [](Value a, const Value& b) {
                             a.include(b);
                             return a;
                           });
  }

  RangeBounds bounds_of(std::uint32_t first, std::uint32_t count) const {
    return reduce(first, count, RangeBounds{},
                  [](RangeBounds& range, const BuildBox& box) { range.include(box); });
  }

  float blocks(std::uint32_t count) const {
    return static_cast<float>((count + options_.block - 1) / options_.block);
  }

  /// Partitions the range and tells how many boxes went left; false: the range should be a leaf.
  bool choose_split(const RangeBounds& range, std::uint32_t first, std::uint32_t count,
                    std::uint32_t depth, std::uint32_t& left) {
    if (count <= options_.block) return false;
    if (depth >= options_.max_depth) return halve(count, left);

    const Binning binning(range.centroids);
    const Histogram histogram = reduce(
        first, count, Histogram{}, [&](Histogram& h, const BuildBox& box) { h.add(binning, box); });
    const Split split = best_split(histogram, count);

    // A leaf costs its blocks, a split one step and the blocks below, weighed by area.
    const float area = range.boxes.half_area();
    const float leaf_cost = blocks(count) * area;
    if (count <= options_.leaf_max && leaf_cost <= options_.node_cost * area + split.cost)
      return false;
    if (split.cost == kInf) return count > options_.leaf_max && halve(count, left);

    const auto goes_left = [&](const BuildBox& box) {
      std::array<int, 4> bins;
      binning.bins_of(box, bins);
      return bins[split.axis] < split.bin;
    };
    const auto begin = boxes_.begin() + first;
    left = static_cast<std::uint32_t>(std::partition(begin, begin + count, goes_left) - begin);
    return true;
  }

  static bool halve(std::uint32_t count, std::uint32_t& left) {
    left = count / 2;
    return true;
  }

  Split best_split(const Histogram& histogram, std::uint32_t count) const {
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<float, kBins> right_cost{};
      Bounds bounds;
      std::uint32_t below = 0;
      for (std::size_t bin = kBins - 1; bin > 0; --bin) {
        bounds.include(histogram.bounds[axis][bin]);
        below += histogram.counts[axis][bin];
        right_cost[bin] = below == 0 ? 0 : blocks(below) * bounds.half_area();
      }
      bounds = Bounds{};
      below = 0;
      for (std::size_t bin = 1; bin < kBins; ++bin) {
        bounds.include(histogram.bounds[axis][bin - 1]);
        below += histogram.counts[axis][bin - 1];
        if (below == 0 || below == count) continue;
        const float cost = blocks(below) * bounds.half_area() + right_cost[bin];
        if (cost < best.cost) best = {cost, axis, static_cast<int>(bin)};
      }
    }
    return best;
  }

  Column<BuildBox>& boxes_;
  const BinaryOptions& options_;
  BinaryNode* nodes_;
};

}  // namespace

BinaryTree build_binary_tree(Column<BuildBox>& boxes, const BinaryOptions& options) {
  BinaryTree tree;
  tree.box_count = static_cast<std::uint32_t>(boxes.size());
  if (boxes.empty()) return tree;
  const std::size_t bytes = 2 * boxes.size() * sizeof(BinaryNode);
  tree.slots = Arena(bytes);
  tree.slots.take(bytes);
  Builder builder(boxes, options, reinterpret_cast<BinaryNode*>(tree.slots.at(0)));
  builder.build(0, 0, tree.box_count, 0);
  return tree;
}

}  // namespace sightline
