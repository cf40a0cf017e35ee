#pragma once
/// Which points lie inside of what a scene's triangles enclose, exactly.

#include "core/base/watch.h"
#include "core/run/engine.h"

namespace sightline {

enum class InsideMethod {
  kParity,   ///< inside: a ray that leaves crosses an odd number of triangles
  kWinding,  ///< inside: it crosses not as many fronts as backs
};

/// Columns of n slots.
struct InsideAnswers {
  Column<std::uint8_t> inside;      ///< 1 or 0; of a point on a triangle 0
  Column<std::uint8_t> on_surface;  ///< 1: exactly on a triangle
  /// 1: rays in three directions say the same. Around a closed mesh they always do (for the
  /// winding number if its triangles are oriented alike); where they do not it has holes.
  Column<std::uint8_t> reliable;
  Column<std::int64_t> winding;  ///< backs less fronts, of the first direction; only for kWinding
  std::uint64_t open_edges = 0;  ///< see below
};

/// Crossings are counted once (Crossings::kOnce), so that edges and corners on the way do no harm.
/// `options.resolved` says which instances count; its sides must be all or none. Points are finite.
/// `reserve` is asked for what does not grow with the points. Errors: its own, and those of
/// Engine::count.
Status points_inside(const Engine& engine, const Scene& scene, const Column<Vec3d>& points,
                     InsideMethod method, const Deadline& deadline, const RayOptions& options,
                     const ReserveBytes& reserve, InsideAnswers& answers);

/// The number of open edges of the triangles that count, for this method, summed over all
/// placements. Without open edges every answer is right. Each mesh is examined alone. Errors:
/// DEADLINE, CANCELLED, those of `reserve`. Throws std::bad_alloc.
Result<std::uint64_t> open_edges(const Scene& scene, const ResolvedFilter* resolved,
                                 InsideMethod method, const Deadline& deadline,
                                 const ReserveBytes& reserve);

/// Distances of points from the nearest triangle, negative inside, rounded correctly; 0 on it, +inf
/// beyond max_distance.
/// Errors: those of Engine::nearest and points_inside.
Status signed_distances(const Engine& engine, const Scene& scene, const Column<Vec3d>& points,
                        InsideMethod method, double max_distance, const Deadline& deadline,
                        const RayOptions& options, const ReserveBytes& reserve,
                        Column<double>& distances, InsideAnswers& answers);

}  // namespace sightline
