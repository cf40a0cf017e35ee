#pragma once
/// Decodes questions about the distance between two selections, and encodes their answers, as JSON.
///
///   {"a":{"names":["house*"]},"b":{"nodes":[7]},"max_distance":2,"pairs":"triangles","limit":100}
///
/// "a" and "b" select triangles as "include" does for rays, and "exclude" inside of one leaves some
/// out. "pairs": "closest" (default), "triangles" or "nodes"; the latter two need "max_distance"
/// (scene units; null, the default: none). "limit": the most pairs listed (1000). "self": false and
/// "adjacent": false leave out pairs of a node with itself, and of a node with its parent.
/// "kinds": true, for "nodes": how both lie to each other. "fields": of both ends. "include",
/// "exclude" and "work": as for rays; they apply to both.

#include <array>
#include <optional>
#include <string>

#include "core/query/clearance.h"
#include "proto/json/hit_json.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// The fields of an end of a pair: a point of a triangle.
inline constexpr FieldSet kEndFields = fields_where([](const HitFieldRow& row) {
  return row.source == FieldSource::kScene || row.field == HitField::kInstance ||
         row.field == HitField::kPosition;
});
inline constexpr FieldSet kDefaultEndFields{
    HitField::kInstance, HitField::kPrimitive, HitField::kTriangle, HitField::kPosition,
    HitField::kNode,     HitField::kNodeId,    HitField::kMesh};

/// One selection: what `choice` selects without what `exclude` selects.
struct ClearanceSide {
  TriangleChoice choice;
  std::optional<TriangleChoice> exclude;
};

/// A decoded question.
struct ClearanceQuery {
  std::array<ClearanceSide, 2> sides;  ///< a and b
  ClearanceQuestion question;
  QueryOptions options;  ///< its fields are those of the ends
};

/// The triangles of one side of all pairs as hits, a slot for each pair, with terms for the fields
/// of the question. Of the details only the positions are set.
struct ClearanceEnds {
  HitBatch hits;
  Column<HitDetail> details;
  HitTerms terms;
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays, 422 DISTANCE_NEGATIVE, DISTANCE_MISSING. max_limit: the largest "limit" accepted.
Result<ClearanceQuery> decode_clearance(std::string& body, std::uint64_t max_limit);

/// "duplicate", "a_in_b", "b_in_a", "crossing", "touching", "near", "apart".
std::string_view clash_kind_name(ClashKind kind);

/// Encodes the closest pair: {"pair":{"distance":1.5,"a":{"instance":0,"primitive":0,"triangle":7,
/// "position":[x,y,z],"node":"house","node_id":3,"mesh":null},"b":{...}}}; the pair is null if
/// there is none within the distance. Several pairs: {"total":2,"pairs":[...]}. With kinds:
/// {"total":1,"kinds":{"duplicate":0,..},"pairs":[{"kind":"crossing","depth":0.5,"distance":0,..}]};
/// a depth that is not defined is null.
std::string encode_clearance(const ClearanceAnswer& answer, const ClearanceQuestion& question,
                             FieldSet fields, const ClearanceEnds& a, const ClearanceEnds& b);

}  // namespace sightline

// Tests: tests/integration/clearance_test.py
