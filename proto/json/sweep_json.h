#pragma once
/// Decodes questions about shapes that are swept through a scene, as JSON.
///
///   {"sweeps":[{"origin":[x,y,z],"direction":[x,y,z],"tmin":0,"tmax":10,"radius":1},
///              {"from":[x,y,z],"to":[x,y,z],"direction":[x,y,z],"radius":1},
///              {"origin":[x,y,z],"direction":[x,y,z],"half":[x,y,z]},
///              {"origin":[x,y,z],"direction":[x,y,z],"half":[x,y,z],"rotation":[x,y,z,w]}],
///    "fields":["t","position","normal"]}
///
/// A sphere has "radius", a capsule two ends and "radius", a box "half" and, if it is turned,
/// "rotation" or "axes"; other members are those of a ray. "fields": of the contacts. "include",
/// "exclude", "strict", "mask", "work", "timeout_ms" and "threads": as for rays.

#include <string>

#include "core/query/sweep_batch.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// The fields of a contact. It has no attributes, because a contact is a point of a triangle that
/// need not be on the path.
inline constexpr FieldSet kContactFields = fields_where([](const HitFieldRow& row) {
  return row.source == FieldSource::kRay || row.source == FieldSource::kScene ||
         row.field == HitField::kPosition || row.field == HitField::kNormal;
});
/// The fields of a request that does not choose any.
inline constexpr FieldSet kDefaultContactFields{
    HitField::kT,        HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNode,     HitField::kMesh};

/// What a body may contain.
struct SweepJsonRules {
  std::size_t max_sweeps = 10'000'000;
  /// False: the body has options only.
  bool has_sweeps = true;
  bool has_fields = true;  ///< true: "fields" is allowed
  FieldSet default_fields = kDefaultContactFields;
};

/// A decoded question.
struct SweepQuery {
  SweepBatch sweeps;  ///< checked by check_sweeps
  QueryOptions options;
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays, the codes of check_sweeps, and 413 SWEEPS_TOO_MANY.
Result<SweepQuery> decode_sweeps(std::string& body, const SweepJsonRules& rules);

/// The error of an invalid sweep, with a pointer below /sweeps.
Error error_of(const SweepFault& fault);

}  // namespace sightline

// Tests: tests/integration/sweeps_test.py
