#pragma once
/// The judge of ray queries: the answers of docs/reference/contract.md over a list of float64 triangles, by
/// integer arithmetic. Shares no code with core/geometry, core/bvh or core/trace. A tree with
/// conservative tests (conservative.h) decides only which triangles the integers look at.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/query/ray_batch.h"
#include "tests/oracle/conservative.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct OracleHit {
  std::size_t triangle = 0;  ///< index in the list that the oracle was made from
  Rational t;
  double t_rounded = 0;  ///< round_to_double(t): +-inf beyond the float64 range
};

/// Immutable; may be asked from many threads at once. The index of a triangle is its id: the
/// smaller one wins when t is equal.
class SceneOracle {
 public:
  /// Non-finite triangles and triangles without area are dropped; their numbers stay theirs.
  explicit SceneOracle(std::span<const Triangle> triangles);

  // All preconditions: the ray passes check_rays.
  std::optional<OracleHit> closest(const Ray& ray) const;
  bool any(const Ray& ray) const;
  /// Sorted by (exact t, triangle).
  std::vector<OracleHit> all(const Ray& ray) const;
  std::size_t count(const Ray& ray) const { return all(ray).size(); }

  /// Every triangle in whose bounding box the whole line may be: what a textbook test would be
  /// asked about under a perfect tree. `ids` is overwritten; in no order.
  void near(const Ray& ray, std::vector<std::uint32_t>& ids) const;

  std::size_t dropped_not_finite() const { return dropped_not_finite_; }
  std::size_t dropped_no_area() const { return dropped_no_area_; }

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t first = 0;  ///< leaf: first entry; inner: the right child (the left one follows)
    std::uint32_t count = 0;  ///< 0: inner
  };
  struct Entry {
    Triangle triangle;
    std::uint32_t id = 0;
  };

  void build(std::span<Entry> entries, std::uint32_t first);
  /// Calls visit(entry) for everything that the conservative tests let through; visit returns the
  /// bound for t of what is still of interest, or -inf to stop.
  template <class Visit>
  void walk(const Ray& ray, Visit&& visit) const;

  std::vector<Entry> entries_;
  std::vector<Node> nodes_;
  std::size_t dropped_not_finite_ = 0;
  std::size_t dropped_no_area_ = 0;
};

}  // namespace sightline::oracle
