#pragma once
/// Binned surface-area heuristic [Wald2007]: counts boxes in bins by their centroids, on all three
/// axes at once. Usage: construct Binning and Histogram, add() the boxes, then ask for the best()
/// cut.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/bvh/build_box.h"

namespace sightline {

/// The number of triangles that a leaf tests at once, as a power of two. It is part of the cost
/// because a leaf costs whole blocks.
struct BlockSize {
  std::uint32_t log2 = 0;
  /// The blocks that `triangles` triangles need, in each lane.
  Float4 blocks(Int4 triangles) const {
    triangles += Int4::all((1 << log2) - 1);
    return Float4::of(Int4{triangles.v >> Int4::all(static_cast<int>(log2)).v});
  }
};

/// A cut of a range of boxes into a left and a right side. Its cost is the sum over both sides of
/// half the surface area times the number of blocks. Infinite: there is no cut.
struct Split {
  float cost = std::numeric_limits<float>::infinity();
  std::size_t axis = 0;
  std::uint32_t place = 0;  ///< the boxes in bins below it, or the sorted boxes before it, go left
};

/// The cheapest cut of each axis.
struct CheapestPerAxis {
  Float4 cost = Float4::all(std::numeric_limits<float>::infinity());  ///< lane 3 has no meaning
  Int4 place = Int4::all(0);

  /// Takes the cuts at a place on those axes on which they are cheaper than all before.
  void consider(Float4 cost_here, int place_here) {
    const Mask4 cheaper = less(cost_here, cost);
    cost = min(cost_here, cost);
    place = select(cheaper, Int4::all(place_here), place);
  }
  /// The cheapest cut; of equal ones that with the lowest place, then axis.
  Split of_all_axes() const {
    alignas(16) std::array<float, 4> costs;
    cost.store(costs.data());
    Split best;
    int best_place = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (costs[axis] < best.cost || (costs[axis] == best.cost && place[axis] < best_place)) {
        best_place = place[axis];
        best = {costs[axis], axis, static_cast<std::uint32_t>(best_place)};
      }
    }
    return best;
  }
};

/// Maps a doubled centroid (BuildBox::middle) to its bin, on each axis: bin = (middle - origin) *
/// scale. Doubled centroids need no division by two.
class Binning {
 public:
  /// Divides `middles`, the bounds of the doubled centroids of all boxes, into `bins` bins on each
  /// axis. Precondition: bins > 0, `middles` is not empty.
  Binning(const Bounds& middles, std::size_t bins) : origin_(middles.lower.without_last()) {
    alignas(16) std::array<float, 4> size;
    (middles.upper - middles.lower).store(size.data());
    for (float& s : size) s = s > 0 ? static_cast<float>(bins) * 0.9999f / s : 0;
    scale_ = Float4::load(size.data()).without_last();
    last_ = Float4::all(static_cast<float>(bins - 1));
  }
  /// The bin of a doubled centroid, on each axis, not yet rounded down to an integer; at most bins
  /// - 1. If an extent of `middles` is so small that the scale overflows, centroids at its lower
  /// end are in bin 0 and all others in the last bin. If the extent is 0 or itself overflows, all
  /// are in bin 0.
  Float4 place(Float4 middle) const {
    return min(max((middle - origin_) * scale_, Float4::all(0)), last_);
  }
  /// True in all lanes if the bin of a doubled centroid on an axis is below `cut`, which is a bin
  /// above 0 in every lane.
  template <int kAxis>
  Mask4 is_below(Float4 middle, Float4 cut) const {
    // Clamping would not change the outcome. Where place() is 0 because of 0 times infinity, the
    // product is NaN.
    return !less_or_equal(cut, ((middle - origin_) * scale_).spread<kAxis>());
  }

 private:
  Float4 origin_;
  Float4 scale_;
  Float4 last_;
};

/// The number of triangles in each bin of each axis, and the bounds of their boxes.
class Histogram {
 public:
  /// The most bins.
  static constexpr std::size_t kMaxBins = 32;

  /// Empty bins. Precondition: bins <= kMaxBins.
  explicit Histogram(std::size_t bins) : bins_(bins) {
    for (std::size_t bin = 0; bin < bins; ++bin) {
      bounds_[bin] = {};
      counts_[bin] = Int4::all(0);
    }
  }
  /// Counts boxes. Precondition: `binning` has as many bins.
  void add(const Binning& binning, std::span<const BuildBox> boxes) {
    // Neighbours mostly are in one bin, and each waits until the bounds of its predecessor are
    // stored. Two histograms let the processor count two boxes at a time.
    const std::size_t half = boxes.size() < kFewForTwo ? 0 : boxes.size() / 2;
    if (half > 0) {
      Histogram other(bins_);
      for (std::size_t i = 0; i < half; ++i) {
        add(binning, boxes[i]);
        other.add(binning, boxes[half + i]);
      }
      include(other);
    }
    for (const BuildBox& box : boxes.subspan(2 * half)) add(binning, box);
  }
  /// Adds the counts and bounds of another histogram with as many bins.
  void include(const Histogram& other) {
    for (std::size_t bin = 0; bin < bins_; ++bin) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds_[bin].axis[axis].include(other.bounds_[bin].axis[axis]);
      }
      counts_[bin] += other.counts_[bin];
    }
  }

  /// The cheapest cut between two bins; Split::place is the first bin of its right side. The cost
  /// is infinite if on every axis all boxes are in one bin, or if every cost overflows.
  Split best(BlockSize size) const {
    // On all axes at once. If a side has no boxes the cost is NaN: 0 times the infinite surface of
    // an empty box.
    std::array<Float4, kMaxBins> right_cost;
    Side right;
    for (std::size_t bin = bins_ - 1; bin > 0; --bin) {
      right.include(*this, bin);
      right_cost[bin] = size.blocks(right.count) * right.bounds.half_areas();
    }
    CheapestPerAxis cheapest;
    Side left;
    for (std::size_t bin = 1; bin < bins_; ++bin) {
      left.include(*this, bin - 1);
      cheapest.consider(size.blocks(left.count) * left.bounds.half_areas() + right_cost[bin],
                        static_cast<int>(bin));
    }
    return cheapest.of_all_axes();
  }

  /// The bounds of the boxes in bins [begin, end) of an axis; empty if there are none.
  Bounds bounds(std::size_t axis, std::size_t begin, std::size_t end) const {
    Bounds sum;
    for (std::size_t bin = begin; bin < end; ++bin) sum.include(bounds_[bin].axis[axis]);
    return sum;
  }
  /// The number of triangles in bins [begin, end) of an axis.
  std::uint32_t count(std::size_t axis, std::size_t begin, std::size_t end) const {
    int sum = 0;
    for (std::size_t bin = begin; bin < end; ++bin) sum += counts_[bin][axis];
    return static_cast<std::uint32_t>(sum);
  }

 private:
  /// With fewer boxes a second histogram is not worth its cost.
  static constexpr std::size_t kFewForTwo = 128;

  void add(const Binning& binning, const BuildBox& box) {
    const Int4 place = binning.place(box.middle()).truncated();
    const Float4 low = Float4::load(box.lower);
    const Float4 high = Float4::load(box.upper);
    add<0>(place, low, high, box.count);
    add<1>(place, low, high, box.count);
    add<2>(place, low, high, box.count);
  }
  template <std::size_t kAxis>
  void add(Int4 place, Float4 low, Float4 high, std::uint32_t count) {
    const auto bin = static_cast<std::uint32_t>(place[kAxis]);
    bounds_[bin].axis[kAxis].include(low, high);
    counts_[bin].v[kAxis] += static_cast<int>(count);
  }

  /// All bins on one side of a cut, for each axis.
  struct Side {
    BoundsPerAxis bounds;
    Int4 count{};

    void include(const Histogram& histogram, std::size_t bin) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        bounds.axis[axis].include(histogram.bounds_[bin].axis[axis]);
      count += histogram.counts_[bin];
    }
  };
  struct Raw {
    Raw() {}  // bins are set as far as they are used
    BoundsPerAxis& operator[](std::size_t bin) { return bin_[bin]; }
    const BoundsPerAxis& operator[](std::size_t bin) const { return bin_[bin]; }
    union {
      BoundsPerAxis bin_[kMaxBins];
    };
  };

  std::size_t bins_;
  Raw bounds_;
  std::array<Int4, kMaxBins> counts_;  ///< by axis
};

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
