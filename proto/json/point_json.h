#pragma once
/// Decodes questions about points, and encodes their answers, as JSON: distance to the scene,
/// nearest triangles, inside, sky.
///
///   {"points":[[x,y,z],...],"max_distance":5,"count":3,"fields":["distance","node"],
///    "method":"parity"}
///
/// "max_distance": scene units; null, the default: no limit. "count": number of triangles for each
/// point (1). "method": "parity", "winding" or "solid_angle". "fields": of the nearest triangles.
/// "include", "exclude", "strict", "mask", "work", "timeout_ms" and "threads": as for rays.

#include <limits>
#include <string>

#include "core/base/column.h"
#include "core/query/inside_answers.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// The fields of a nearest triangle: all but those of a ray.
inline constexpr FieldSet kNearestFields = fields_where([](const HitFieldRow& row) {
  return row.field != HitField::kT && row.source != FieldSource::kCost;
});
/// The fields of a request that does not choose any.
inline constexpr FieldSet kDefaultNearestFields{
    HitField::kDistance, HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNode,     HitField::kMesh};

/// What a body may contain.
struct PointJsonRules {
  std::size_t max_points = 10'000'000;
  /// False: the body has options only.
  bool has_points = true;
  // True: the body may have this key.
  bool has_method = false, has_max_distance = false, has_count = false, has_fields = false;
  /// True: "normals", "seed", "distribution" and "min_distance" are allowed, and "count" is the
  /// number of directions.
  bool has_directions = false;
  std::uint64_t default_count = 1, max_count = 1000;  ///< of "count"
  FieldSet default_fields = kDefaultNearestFields;
};

/// A decoded question.
struct PointQuery {
  Column<Vec3d> points;  ///< finite
  InsideMethod method = InsideMethod::kParity;
  double max_distance = std::numeric_limits<double>::infinity();
  std::uint64_t count = 1;
  Column<Vec3d> normals;     ///< as many as points, finite, not zero; +Y if none were sent
  bool has_normals = false;  ///< normals were sent
  std::uint64_t seed = 0;
  bool uniform = false;     ///< directions are uniform, else with the density of the cosine
  double min_distance = 0;  ///< at most max_distance
  bool asks_rays = false;   ///< `count` is a number of directions
  QueryOptions options;

  /// The number of items of the request, for an estimate of its cost.
  std::uint64_t items() const { return points.size() * (asks_rays ? count : 1); }
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays, 413 POINTS_TOO_MANY, 422 DISTANCE_NEGATIVE, COUNT_ZERO, NORMAL_ZERO,
/// RAY_LIMITS_REVERSED.
Result<PointQuery> decode_points(std::string& body, const PointJsonRules& rules);

/// The answer for n points: columns of n slots, which the caller owns. `winding` may be empty if
/// the method is parity, `inside` and `on_surface` if distances are encoded.
struct InsideColumns {
  InsideMethod method = InsideMethod::kParity;
  std::span<const std::uint8_t> inside, on_surface, reliable;
  std::span<const std::int64_t> winding;
  std::span<const double> generalized, error;  ///< of kSolidAngle
  /// Number of open edges of the triangles that count. If there are any, answers are not proved.
  std::uint64_t open_edges = 0;
};

/// Encodes {"method":"parity","inside":[true,null],"on_surface":[false,true],
/// "reliable":[true,true]}; for the method "winding" also "winding":[1,0]; for "solid_angle" also
/// "winding":[0.75,null] and "error":[1e-15,0]; if there are open edges also
/// "unreliable":{"reason":"OPEN_EDGES","open_edges":4}. "inside" is null for points on the surface.
std::string encode_inside(const InsideColumns& columns);
/// Encodes {"method":"parity","distance":[-1.5,null],"reliable":[true,true]}, and "unreliable" if
/// there are open edges; "winding" as encode_inside. A distance that is not finite is null.
std::string encode_signed_distances(const InsideColumns& columns, std::span<const double> distance);
/// Checks the normals of a query, or sets them to +Y if none were sent. Errors: 422 LENGTH_WRONG,
/// NORMAL_ZERO.
Status finish_normals(PointQuery& query);

/// Encodes {"directions":256,"counts":[199,0],"ratios":[0.77734375,0]}: for each point the number
/// of its directions that meet nothing, and their share.
std::string encode_sky(std::uint64_t directions, std::span<const std::uint64_t> counts);
/// Encodes the value of "unreliable".
std::string encode_unreliable(std::uint64_t open_edges);

}  // namespace sightline

// Tests: tests/integration/points_test.py
