#pragma once
/// Trees, and the path of a ray through them, as JSON.

#include <optional>
#include <string>

#include "core/base/watch.h"
#include "core/query/hit_filter.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene.h"
#include "core/trace/search/nearest_miss.h"

namespace sightline {

/// Returns {"boxes":[{"parent":null,"leaf":false,"space":"world","min","max","verdict":"entered",
/// "t_enter","t_exit"},{"parent":0,"leaf":true,..,"verdict":"missed","miss":["x","y"]}, ..],
/// "truncated":false}, in the order of the visit.
///
/// Verdicts of boxes: entered; missed (with the slabs that exclude each other); behind and beyond
/// (outside of the ray's limits); farther (than a hit found before). An entered leaf has
/// "triangles":[{"instance","primitive","triangle","verdict","t"}] with the verdicts hit, missed or
/// filtered; the last has "by": cull, include, exclude or mask.
///
/// Precondition: the closest hit of the ray was requested before, which builds the trees near the
/// ray. `resolved` is the resolved form of `filter`; null: all triangles. Errors: those of
/// chosen_sides for the parts of the filter.
Result<std::string> encode_explanation(const Scene& scene, const Ray& ray, const HitFilter& filter,
                                       const ResolvedFilter* resolved, const Deadline& deadline,
                                       const ReserveBytes& reserve);

/// Returns {"instance","primitive","triangle","node","distance"}, or null if there is none.
std::string encode_nearest_miss(const Scene& scene, const std::optional<NearestMiss>& miss);

/// Returns
/// {"complete","pending","trees":[{"placements","nodes","leaves","blocks","triangles","depth",
/// "shallowest","mean_depth","arity","sah_cost","overlap","contained"},..],"total","top":{..}}: the
/// first hundred trees that are built, and the top tree, or null if there is none. "pending" is the
/// number of unbuilt subtrees. With `level` also "level":{"boxes":[{"min","max","leaf"},..],
/// "truncated"}: the boxes at this depth, where the root is level 0.
std::string encode_trees(const Scene& scene, std::optional<std::uint32_t> level = {});
/// The most boxes of "level".
inline constexpr std::size_t kMostLevelBoxes = 2000;

}  // namespace sightline

// Tests: tests/integration/lectures_test.py
