#pragma once
/// A scene as the oracle sees it: one list of float64 triangles in the order of their ids.

#include <cstdint>
#include <vector>

#include "core/scene/scene.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct WorldTriangles {
  std::vector<Triangle> triangles;
  /// Index of the first triangle of each instance, and the total.
  std::vector<std::size_t> first;

  explicit WorldTriangles(const Scene& scene);
  TriangleId id(std::size_t index) const;
  std::size_t index(TriangleId id) const { return first[id.instance] + id.triangle; }
};

}  // namespace sightline::oracle
