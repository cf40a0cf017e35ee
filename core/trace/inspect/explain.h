#pragma once
/// The boxes and triangles that one ray was tested with, in the order of a visit. Slow and simple;
/// it visits as the kernels do.

#include <cstdint>
#include <vector>

#include "core/geometry/ray_box.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

struct ExplainedTriangle {
  enum class Verdict : std::uint8_t {
    kHit,
    kMissed,    ///< the line passes it, or its t is outside of the ray's limits
    kFiltered,  ///< met, but it does not count: cull, include or exclude
  };
  TriangleId id;
  Verdict verdict = Verdict::kMissed;
  double t = 0;  ///< rounded; only where it was met
};

struct ExplainedBox {
  std::int64_t parent = -1;  ///< its number in the list; -1 for the first
  bool is_leaf = false;
  Box3d box;             ///< in the tree's space: the world, or that of a mesh placed often
  bool in_mesh = false;  ///< which of them
  RayBoxAnswer met;      ///< of the ray and the box, within the ray's limits
  /// Met, but a hit before it is nearer: not entered.
  bool behind_hit = false;
  std::vector<ExplainedTriangle> triangles;  ///< of a leaf that was entered
};

/// The list ends after `most` boxes. Precondition: the trees near the ray are there (a closest hit
/// was asked for). Throws std::bad_alloc.
struct Explanation {
  std::vector<ExplainedBox> boxes;
  bool truncated = false;
};
Explanation explain_ray(const SceneView& scene, const Ray& ray, const ResolvedFilter* resolved,
                        std::size_t most = 1000);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
