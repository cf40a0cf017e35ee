#pragma once
/// The oracle's own judge, for tests of the oracle only: every ray against every triangle in
/// mpq_class, by another derivation (point on plane and edge sides; in the plane, crossings with
/// the three edges), with no tree and no filter.

#include <optional>
#include <span>
#include <vector>

#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct BruteHit {
  std::size_t triangle = 0;
  mpq_class t;
  bool operator==(const BruteHit&) const = default;
};

std::optional<mpq_class> brute_least_t(const Ray& ray, const Triangle& triangle);
/// Sorted by (t, triangle); closest is the first, any whether there is one.
std::vector<BruteHit> brute_all(const Ray& ray, std::span<const Triangle> triangles);

}  // namespace sightline::oracle
