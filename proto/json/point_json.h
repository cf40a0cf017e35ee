#pragma once
/// Points as JSON, and what is asked of them: how far the scene is, which triangles are nearest,
/// whether they lie inside.
///
///   {"points":[[x,y,z],...],"max_distance":5,"count":3,"fields":["distance","node"],
///    "method":"parity"}
///
/// "max_distance": scene units, null for none (the default); "count": of triangles for each point
/// (1); "method": "parity" or "winding"; "fields" of the nearest triangles; "include", "exclude"
/// and "work" as for rays.

#include <limits>
#include <string>

#include "core/base/column.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// The nearest point of a triangle has all that a hit has, but no t.
inline constexpr FieldSet kNearestFields = [] {
  FieldSet fields = kAllHitFields;
  fields.remove(HitField::kT);
  return fields;
}();
inline constexpr FieldSet kDefaultNearestFields{
    HitField::kDistance, HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNode,     HitField::kMesh};

struct PointJsonRules {
  std::size_t max_points = 10'000'000;
  /// Without, the body has options only.
  bool has_points = true;
  // Whether the body may have the other keys.
  bool has_method = false, has_max_distance = false, has_count = false, has_fields = false;
  /// "normals", "seed", "distribution" and "min_distance"; "count" is then a number of directions.
  bool has_directions = false;
  std::uint64_t default_count = 1, max_count = 1000;
  FieldSet default_fields = kDefaultNearestFields;
};

struct PointQuery {
  Column<Vec3d> points;  ///< finite
  bool by_winding = false;
  double max_distance = std::numeric_limits<double>::infinity();
  std::uint64_t count = 1;
  Column<Vec3d> normals;     ///< as many as points, finite, not zero; +Y where none were sent
  bool has_normals = false;  ///< they were sent
  std::uint64_t seed = 0;
  bool uniform = false;     ///< directions by solid angle, else by the cosine
  double min_distance = 0;  ///< at most max_distance
  bool asks_rays = false;   ///< `count` is a number of directions
  RayQuery options;         ///< without rays

  /// How many items the request is about, which decides where it runs.
  std::uint64_t items() const { return points.size() * (asks_rays ? count : 1); }
};

/// `body` as decode_rays takes it. Errors: as decode_rays, and 413 POINTS_TOO_MANY, 422
/// DISTANCE_NEGATIVE, COUNT_ZERO, NORMAL_ZERO, RAY_LIMITS_REVERSED.
Result<PointQuery> decode_points(std::string& body, const PointJsonRules& rules);

/// Whether points lie inside: columns of n slots; `winding` may be empty.
struct InsideColumns {
  bool by_winding = false;
  std::span<const std::uint8_t> inside, on_surface, reliable;
  std::span<const std::int64_t> winding;
  /// Open edges of the triangles that count. With open edges some answers are not proved.
  std::uint64_t open_edges = 0;
};

/// {"method":"parity","inside":[true,null],"on_surface":[false,true],"reliable":[true,true]}, with
/// "winding":[1,0] for that method, and "unreliable":{"reason":"OPEN_EDGES","open_edges":4} where
/// there are some. On the surface "inside" is null.
std::string encode_inside(const InsideColumns& columns);
/// {"method":"parity","distance":[-1.5,null],"reliable":[true,true]}, and the same besides. A
/// distance that is not finite is null.
std::string encode_signed_distances(const InsideColumns& columns, std::span<const double> distance);
/// Checks the normals of a query, or makes them +Y where none were sent. Errors: 422 LENGTH_WRONG,
/// NORMAL_ZERO.
Status finish_normals(PointQuery& query);

/// {"directions":256,"counts":[199,0],"ratios":[0.77734375,0]}: of so many directions of each point
/// those that meet nothing, and their part.
std::string encode_sky(std::uint64_t directions, std::span<const std::uint64_t> counts);
/// The value of "unreliable".
std::string encode_unreliable(std::uint64_t open_edges);

}  // namespace sightline

// Tests: tests/integration/points_test.py
