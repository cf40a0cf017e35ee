#pragma once
/// The filter of single triangles, for every traversal.

#include <algorithm>
#include <cstdint>

#include "core/query/hit_filter.h"
#include "core/scene/scene.h"

namespace sightline {

/// The sides of a triangle whose hits count: a set of ResolvedFilter's bits. Ignores masks. Cost:
/// two loads, and a binary search in the primitives of the mesh and in lists of single triangles
/// where there are any.
inline std::uint8_t counting_sides(const Scene& scene, const ResolvedFilter& resolved,
                                   TriangleId id) {
  if (resolved.names_triangles()) {
    const auto has = [&](const std::vector<TriangleId>& list) {
      return std::binary_search(list.begin(), list.end(), id);
    };
    if ((resolved.only && !has(*resolved.only)) || has(resolved.without)) return 0;
  }
  const std::size_t first = resolved.first[id.instance];
  const std::size_t end = id.instance + 1 < resolved.first.size() ? resolved.first[id.instance + 1]
                                                                  : resolved.sides.size();
  return resolved.sides[end - first == 1 ? first : first + scene.primitive_of(id)];
}

}  // namespace sightline

// Tests: tests/integration/triangle_filters_test.py
