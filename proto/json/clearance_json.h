#pragma once
/// Decodes questions about the distance between two selections, and encodes their answers, as JSON.
///
///   {"a":{"names":["house*"]},"b":{"nodes":[7]},"max_distance":2,"pairs":"triangles","limit":100}
///
/// "a" and "b" select triangles as "include" does for rays. "pairs": "closest" (default),
/// "triangles" or "nodes"; the latter two need "max_distance" (scene units; null, the default:
/// none). "limit": the most pairs listed (1000). "include", "exclude" and "work": as for rays; they
/// apply to both selections.

#include <string>

#include "core/query/clearance.h"
#include "proto/json/hit_json.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// A decoded question.
struct ClearanceQuery {
  TriangleChoice a, b;
  ClearanceQuestion question;
  RayQuery options;  ///< without rays
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays, 422 DISTANCE_NEGATIVE, DISTANCE_MISSING. max_limit: the largest "limit" accepted.
Result<ClearanceQuery> decode_clearance(std::string& body, std::uint64_t max_limit);

/// Encodes the closest pair: {"pair":{"distance":1.5,"a":{"instance":0,"primitive":0,"triangle":7,
/// "node":"house","mesh":null,"position":[x,y,z]},"b":{...}}}; the pair is null if there is none
/// within the distance. Several pairs: {"total":2,"pairs":[...]}. `a` and `b` have primitive,
/// triangle, node_name and mesh_name of each pair.
std::string encode_clearance(const ClearanceAnswer& answer, ClearancePairs pairs, const HitTerms& a,
                             const HitTerms& b);

}  // namespace sightline

// Tests: tests/integration/clearance_test.py
