#pragma once
/// Binned surface-area heuristic [Wald2007]: counts boxes in bins by their centroids, on all three
/// axes at once. Usage: construct Binning and Histogram, add() each box, then ask for the best()
/// cut.

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/bvh/build_box.h"

namespace sightline {

/// The number of boxes that a leaf tests at once, as a power of two. It is part of the cost because
/// a leaf costs whole blocks.
struct BlockSize {
  std::uint32_t log2 = 0;
  /// The blocks that `boxes` boxes need.
  float blocks(std::uint32_t boxes) const {
    return static_cast<float>(static_cast<int>((boxes + (1u << log2) - 1) >> log2));
  }
};

/// A cut of a range of boxes into a left and a right side. Its cost is the sum over both sides of
/// half the surface area times the number of blocks. Infinite: there is no cut.
struct Split {
  float cost = std::numeric_limits<float>::infinity();
  std::size_t axis = 0;
  std::uint32_t place = 0;  ///< the boxes in bins below it, or the sorted boxes before it, go left
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

 private:
  Float4 origin_;
  Float4 scale_;
  Float4 last_;
};

/// The number of boxes in each bin of each axis, and their bounds.
class Histogram {
 public:
  /// The most bins.
  static constexpr std::size_t kMaxBins = 32;

  /// Empty bins. Precondition: bins <= kMaxBins.
  explicit Histogram(std::size_t bins) : bins_(bins) {
    for (std::size_t bin = 0; bin < bins; ++bin) {
      bounds_[bin] = {};
      counts_[bin] = {};
    }
  }
  /// Counts a box. Precondition: `binning` has as many bins.
  void add(const Binning& binning, const BuildBox& box) {
    const std::array<int, 4> place = binning.place(box.middle()).truncated();
    const Float4 low = Float4::load(box.lower);
    const Float4 high = Float4::load(box.upper);
    add<0>(place, low, high);
    add<1>(place, low, high);
    add<2>(place, low, high);
  }
  /// Adds the counts and bounds of another histogram with as many bins.
  void include(const Histogram& other) {
    for (std::size_t bin = 0; bin < bins_; ++bin) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds_[bin].axis[axis].include(other.bounds_[bin].axis[axis]);
        counts_[bin][axis] += other.counts_[bin][axis];
      }
    }
  }

  /// The cheapest cut between two bins; Split::place is the first bin of its right side. `count` is
  /// the number of boxes that were added. The cost is infinite if on every axis all boxes are in
  /// one bin, or if every cost overflows.
  Split best(std::uint32_t count, BlockSize size) const {
    std::array<std::array<float, 3>, kMaxBins> right_cost;
    Side right;
    for (std::size_t bin = bins_ - 1; bin > 0; --bin) {
      right.include(*this, bin);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        right_cost[bin][axis] =
            size.blocks(right.count[axis]) * right.bounds.axis[axis].half_area();
      }
    }
    Split best;
    Side left;
    for (std::size_t bin = 1; bin < bins_; ++bin) {
      left.include(*this, bin - 1);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float cost = size.blocks(left.count[axis]) * left.bounds.axis[axis].half_area() +
                           right_cost[bin][axis];
        // A side without boxes has no surface: infinity times 0.
        if (left.count[axis] != 0 && left.count[axis] != count && cost < best.cost)
          best = {cost, axis, static_cast<std::uint32_t>(bin)};
      }
    }
    return best;
  }

  /// The bounds of the boxes in bins [begin, end) of an axis; empty if there are none.
  Bounds bounds(std::size_t axis, std::size_t begin, std::size_t end) const {
    Bounds sum;
    for (std::size_t bin = begin; bin < end; ++bin) sum.include(bounds_[bin].axis[axis]);
    return sum;
  }

 private:
  template <std::size_t kAxis>
  void add(const std::array<int, 4>& place, Float4 low, Float4 high) {
    const auto bin = static_cast<std::uint32_t>(place[kAxis]);
    bounds_[bin].axis[kAxis].include(low, high);
    ++counts_[bin][kAxis];
  }

  struct PerAxis {
    std::array<Bounds, 3> axis;
  };
  /// All bins on one side of a cut, for each axis.
  struct Side {
    PerAxis bounds;
    std::array<std::uint32_t, 3> count{};

    void include(const Histogram& histogram, std::size_t bin) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds.axis[axis].include(histogram.bounds_[bin].axis[axis]);
        count[axis] += histogram.counts_[bin][axis];
      }
    }
  };
  struct Raw {
    Raw() {}  // bins are set as far as they are used
    PerAxis& operator[](std::size_t bin) { return bin_[bin]; }
    const PerAxis& operator[](std::size_t bin) const { return bin_[bin]; }
    union {
      PerAxis bin_[kMaxBins];
    };
  };

  std::size_t bins_;
  Raw bounds_;
  std::array<std::array<std::uint32_t, 3>, kMaxBins> counts_;
};

}  // namespace sightline

// Tests: tests/unit/bvh/triangle_tree_test.cpp
