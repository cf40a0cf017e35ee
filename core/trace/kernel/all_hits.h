#pragma once
/// AllHits: collects every triangle that a ray meets; counts all, and returns the first in the
/// order of (exact t, id).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/trace/decision.h"

namespace sightline {

struct TraceCounts;

/// The hits of one ray, for "all" and "count". Construct it for the ray, call accept() or examine()
/// for each triangle that the filter does not exclude, then total() and append_sorted().
///
/// Laws    The answer does not depend on the order in which triangles are added, nor on the widths
///         of their intervals; narrow intervals only save exact comparisons.
/// Memory  Entries of 24 bytes, at most 2 * limit of them (at least kFewest), and half as many
///         again while their vector grows: kBytesOfHit * limit; none with limit 0. Exact t are not
///         stored: two at a time are computed, compared and discarded. A thread traces one ray at a
///         time, so each thread of a batch needs this memory.
/// Cost    O(n) for n triangles, and O(limit log limit) at the end. An exact t is computed for each
///         listed triangle, and for a few whose intervals overlap where the order matters.
/// Errors  std::bad_alloc. The deadline of `counts` is polled; after it has passed, the answer must
///         not be used.
class AllHits {
 public:
  /// Most bytes of memory for each listed hit.
  static constexpr std::size_t kBytesOfHit = 72;

  /// Lists at most `limit` hits; with 0 they are only counted. The arguments must outlive this
  /// object.
  AllHits(const RayQuestion& question, Crossings crossings, std::size_t limit, TraceCounts& counts)
      : question_(question),
        counts_(counts),
        crossings_(crossings),
        limit_(limit),
        room_(limit > kUnlimited / 2 ? kUnlimited : std::max(2 * limit, kFewest)) {}

  /// Adds a triangle that is certainly met inside of its edges and within the limits, at a tau
  /// inside of the interval (ray_setup.h).
  void accept(TriangleId id, Interval tau) {
    ++total_;
    if (limit_ != 0) keep({id, tau});
  }
  /// Adds a triangle if the exact predicate finds that it is met, or crossed for Crossings::kOnce.
  void examine(TriangleId id);

  /// The number of added triangles.
  std::uint64_t total() const { return total_; }
  /// Appends the first `limit` hits in order. Must be called once, after all triangles were added.
  void append_sorted(HitBatch& hits);

 private:
  static constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max(), kFewest = 64;

  struct Entry {
    TriangleId id;
    Interval tau;
  };
  static_assert(3 * sizeof(Entry) == kBytesOfHit);
  using Place = std::vector<Entry>::iterator;
  /// Entries [begin, end) with one and the same exact t.
  struct Same {
    Place begin, end;
    double t = 0;  ///< rounded; set on request
  };

  void keep(const Entry& entry) {
    if (entry.tau.low > farthest_) return;
    if (entries_.size() == entries_.capacity()) make_room();
    entries_.push_back(entry);
  }
  void make_room();
  bool meets(TriangleId id, ExactT& t);
  /// Reduces the entries to the first `limit_`, in any order.
  void drop_all_but_first();
  /// Moves the first `wanted` entries of [begin, end) in the order of hits to its front.
  void select(Place begin, Place end, std::size_t wanted);
  /// Partitions [begin, end) by the t of one of its entries into smaller, equal and larger; returns
  /// the equal ones. Precondition: the range is not empty.
  Same split(Place begin, Place end, bool rounds);
  /// std::sort that polls the clock. Returns false if the deadline passed.
  template <class Less>
  bool sort(Place begin, Place end, Less less);
  /// Appends entries whose order intervals do not decide.
  void append_exactly(Place begin, Place end, HitBatch& hits);

  const RayQuestion& question_;
  TraceCounts& counts_;
  Crossings crossings_;
  std::size_t limit_, room_;
  std::uint64_t total_ = 0;
  std::uint32_t exact_ = 0;  ///< number of exact t that were computed
  /// At least `limit_` entries have a tau that is certainly not above this.
  double farthest_ = std::numeric_limits<double>::infinity();
  std::vector<Entry> entries_;
};

}  // namespace sightline
