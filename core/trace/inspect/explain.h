#pragma once
/// Lists the boxes and triangles with which one ray is tested, in the order of the traversal, to
/// explain an answer to people. It visits nodes as the kernels do, but is slow and simple.

#include <cstdint>
#include <vector>

#include "core/geometry/ray_box.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene_view.h"

namespace sightline {

/// A triangle in a leaf that the ray entered, and what was decided about it.
struct ExplainedTriangle {
  /// The decision.
  enum class Verdict : std::uint8_t {
    kHit,       ///< the ray meets it, and it counts
    kMissed,    ///< the ray does not meet it within its limits
    kFiltered,  ///< the ray meets it, but a filter excludes it
  };
  TriangleId id;
  Verdict verdict = Verdict::kMissed;
  double t = 0;  ///< rounded; set if the ray meets the triangle
};

/// A box of a tree, and the result of its test.
struct ExplainedBox {
  std::int64_t parent = -1;  ///< index of the parent box in Explanation::boxes; -1 for the root
  bool is_leaf = false;
  Box3d box;  ///< in world space, or in the mesh space of `instance`
  /// Of a box of the tree of a mesh that is placed often: the placement that the ray entered. kNone:
  /// the box is in world space.
  std::uint32_t instance = kNone;
  RayBoxAnswer met;  ///< the result of ray_box for the ray and the box, within the ray's limits
  /// True if the ray meets the box, but does not enter it because an earlier hit is nearer.
  bool behind_hit = false;
  /// the triangles, if this is a leaf that the ray entered
  std::vector<ExplainedTriangle> triangles;
};

/// The list, of at most `most` boxes; truncated: there were more.
struct Explanation {
  std::vector<ExplainedBox> boxes;
  bool truncated = false;
};
/// Traces the ray and returns the list. `resolved` may be null: all triangles count; its masks are
/// ignored (resolve_for_rays for one ray makes none). Preconditions: the ray has passed check_rays,
/// and the trees near the ray are built, as they are after a closest hit was requested. Throws
/// std::bad_alloc.
Explanation explain_ray(const SceneView& scene, const Ray& ray, const ResolvedFilter* resolved,
                        std::size_t most = 1000);

}  // namespace sightline

// Tests: tests/integration/filters_test.py
