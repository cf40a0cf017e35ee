#pragma once
/// Clearance: the pairs of triangles of two groups that are closest, or within a distance, exactly.

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

/// False for pairs of nodes that the question leaves out (`self`, `adjacent`). is_alike: both
/// selections are equal.
bool may_pair_nodes(const SceneDescription& scene, const ClearanceQuestion& question, bool is_alike,
                    std::uint32_t a, std::uint32_t b);

/// One search: construct, find(), check stopped() and too_many(), write(). Answers
/// Engine::clearance.
class Clearance {
 public:
  /// All arguments must outlive this object.
  Clearance(const Scene& scene, const TriangleGroup& a, const TriangleGroup& b,
            const Deadline& deadline)
      : scene_(scene), a_(a), b_(b), deadline_(deadline) {}

  /// Finds the pairs of the question. What is closest is decided exactly: by distance, and at equal
  /// distance by ids. Stops if it finds more than `most` pairs. Precondition: called once. Throws
  /// std::bad_alloc.
  void find(const ClearanceQuestion& question, std::uint64_t most);
  /// Writes the first `limit` pairs in the order that ClearanceAnswer states, and the number of
  /// all. Throws std::bad_alloc.
  void write(std::uint64_t limit, ClearanceAnswer& answer) const;

  /// True if there were more pairs than allowed: the results are unusable.
  bool too_many() const { return too_many_; }
  /// True if the deadline passed: the results are unusable.
  bool stopped() const { return stopped_; }
  const TraceCounts& counts() const { return counts_; }

 private:
  struct Found {
    TriangleId a, b;
    DistanceRange range;
    std::unique_ptr<const ExactDistance> exact;  ///< computed when first needed; many kilobytes
    bool is_zero = false;                        ///< the distance is known to be 0
    bool crosses = false;                        ///< some two triangles of the nodes cross

    std::pair<TriangleId, TriangleId> ids() const { return {a, b}; }
  };
  void look_at_leaves(const TriangleGroup::Node& a, const TriangleGroup::Node& b);
  void offer(Found found);
  std::uint32_t node_of(TriangleId triangle) const;
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
