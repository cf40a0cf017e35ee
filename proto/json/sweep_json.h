#pragma once
/// Shapes that are swept through a scene, as JSON.
///
///   {"sweeps":[{"origin":[x,y,z],"direction":[x,y,z],"tmin":0,"tmax":10,"radius":1},
///              {"origin":[x,y,z],"direction":[x,y,z],"half":[x,y,z]}],"fields":["t","position"]}
///
/// A sphere has a radius, an axis-aligned box half extents; the rest is that of a ray.
/// "fields" of the contacts; "include", "exclude" and "work" as for rays.

#include <string>

#include "core/query/sweep_batch.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// A contact is a place on a triangle and no more: the surface need not be met there by a line.
inline constexpr FieldSet kContactFields = fields_where([](const HitFieldRow& row) {
  return row.source == FieldSource::kRay || row.source == FieldSource::kScene ||
         row.field == HitField::kPosition;
});
inline constexpr FieldSet kDefaultContactFields{
    HitField::kT,        HitField::kInstance, HitField::kPrimitive, HitField::kTriangle,
    HitField::kPosition, HitField::kNode,     HitField::kMesh};

struct SweepJsonRules {
  std::size_t max_sweeps = 10'000'000;
  /// Without, the body has options only.
  bool has_sweeps = true;
  bool has_fields = true;
  FieldSet default_fields = kDefaultContactFields;
};

struct SweepQuery {
  SweepBatch sweeps;  ///< checked by check_sweeps
  RayQuery options;   ///< without rays
};

/// `body` as decode_rays takes it. Errors: as decode_rays, the codes of check_sweeps and 413
/// SWEEPS_TOO_MANY.
Result<SweepQuery> decode_sweeps(std::string& body, const SweepJsonRules& rules);

/// The error of a sweep that check_sweeps refuses, below /sweeps.
Error error_of(const SweepFault& fault);

}  // namespace sightline

// Tests: tests/integration/sweeps_test.py
