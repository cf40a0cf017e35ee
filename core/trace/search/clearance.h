#pragma once
/// Two groups of triangles against each other: the closest pair, or all within a distance, exactly.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/geometry/point_triangle.h"
#include "core/query/clearance.h"
#include "core/scene/scene.h"
#include "core/trace/search/triangle_group.h"
#include "core/trace/trace_counts.h"

namespace sightline {

class Clearance {
 public:
  /// Everything given outlives this object.
  Clearance(const Scene& scene, const TriangleGroup& a, const TriangleGroup& b,
            const Deadline& deadline)
      : scene_(scene), a_(a), b_(b), deadline_(deadline) {}

  /// Which pairs are wanted, and their order, is decided exactly: by distance, at the same distance
  /// by ids. Stops after `most` pairs. Throws std::bad_alloc.
  void find(const ClearanceQuestion& question, std::uint64_t most);
  /// The first `limit` of them, and how many there were.
  void write(std::uint64_t limit, ClearanceAnswer& answer) const;

  /// There are more than were allowed, or the deadline passed: what was found is unusable.
  bool too_many() const { return too_many_; }
  bool stopped() const { return stopped_; }
  const TraceCounts& counts() const { return counts_; }

 private:
  struct Found {
    const TriangleGroup::Member* a = nullptr;
    const TriangleGroup::Member* b = nullptr;
    DistanceRange range;
    std::unique_ptr<const ExactDistance> exact;  ///< once it was needed; many kilobytes
    bool is_zero = false;                        ///< known to be, with or without `exact`

    std::pair<TriangleId, TriangleId> ids() const { return {a->id, b->id}; }
  };
  void look_at_leaves(const TriangleGroup::Node& a, const TriangleGroup::Node& b);
  void offer(Found found);
  bool is_within(Found& found);
  bool comes_before(Found& x, Found& y);
  const ExactDistance& exact_of(Found& found);
  bool is_of_interest(const TriangleGroup::Node& a, const TriangleGroup::Node& b) const;
  double reach() const;

  const Scene& scene_;
  const TriangleGroup& a_;
  const TriangleGroup& b_;
  const Deadline& deadline_;
  ClearanceQuestion question_;
  std::uint64_t most_ = 0;
  std::optional<Found> closest_;
  std::vector<Found> all_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Found> by_nodes_;
  bool too_many_ = false, stopped_ = false;
  TraceCounts counts_;
};

}  // namespace sightline
