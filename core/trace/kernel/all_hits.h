#pragma once
/// Every triangle that one ray meets: all are counted, and the first in the order of (exact t, id)
/// are returned.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/trace/decision.h"

namespace sightline {

struct TraceCounts;

/// The hits of "all" and "count".
///
/// Laws    An answer depends neither on the order in which triangles come nor on how wide their
///         intervals are: these only spare exact comparisons.
/// Memory  Entries of 24 bytes, at most 2 * limit of them (kFewest if that is more), and half as
///         many again while their vector grows: kBytesOfHit * limit; none with limit 0. Exact t are
///         not stored, however many are equal: two at a time are computed, compared and discarded.
///         A thread traces one ray at a time, so a batch takes that for each thread.
/// Cost    O(n) for n triangles met, and O(limit log limit) at the end. Exact t: one for each listed
///         triangle, and a few where intervals overlap and the order matters.
/// Errors  std::bad_alloc. The deadline of `counts` is polled; once it has passed, answers must not
///         be used.
class AllHits {
 public:
  static constexpr std::size_t kBytesOfHit = 72;

  AllHits(const RayQuestion& question, Crossings crossings, std::size_t limit, TraceCounts& counts)
      : question_(question),
        counts_(counts),
        crossings_(crossings),
        limit_(limit),
        room_(limit > kUnlimited / 2 ? kUnlimited : std::max(2 * limit, kFewest)) {}

  /// A triangle that is certainly met inside of its edges and within the limits, at a tau inside
  /// the interval.
  void accept(TriangleId id, Interval tau) {
    ++total_;
    if (limit_ != 0) keep({id, tau});
  }
  /// Decides exactly whether a triangle is met.
  void examine(TriangleId id);

  std::uint64_t total() const { return total_; }
  /// Appends the first `limit` hits in order. Call it once, last.
  void append_sorted(HitBatch& hits);

 private:
  static constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max(), kFewest = 64;

  struct Entry {
    TriangleId id;
    Interval tau;
  };
  static_assert(3 * sizeof(Entry) == kBytesOfHit);
  using Place = std::vector<Entry>::iterator;
  /// Entries [begin, end) that are met at one t.
  struct Same {
    Place begin, end;
    double t = 0;  ///< rounded; only if asked for
  };

  void keep(const Entry& entry) {
    if (entry.tau.low > farthest_) return;
    if (entries_.size() == entries_.capacity()) make_room();
    entries_.push_back(entry);
  }
  void make_room();
  bool meets(TriangleId id, ExactT& t);
  /// Leaves the first `limit_` entries, in any order.
  void drop_all_but_first();
  /// Moves the first `wanted` entries of [begin, end) to its front.
  void select(Place begin, Place end, std::size_t wanted);
  /// Puts entries of [begin, end) before, at and behind one of them; returns those at it.
  /// Precondition: there are some.
  Same split(Place begin, Place end, bool rounds);
  /// std::sort that polls the clock. False if the time is over.
  template <class Less>
  bool sort(Place begin, Place end, Less less);
  /// Appends entries whose intervals do not order them.
  void append_exactly(Place begin, Place end, HitBatch& hits);

  const RayQuestion& question_;
  TraceCounts& counts_;
  Crossings crossings_;
  std::size_t limit_, room_;
  std::uint64_t total_ = 0;
  std::uint32_t exact_ = 0;  ///< exact t so far
  /// At least `limit_` entries are met at a tau that is not beyond.
  double farthest_ = std::numeric_limits<double>::infinity();
  std::vector<Entry> entries_;
};

}  // namespace sightline
