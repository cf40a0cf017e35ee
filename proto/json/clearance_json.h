#pragma once
/// How far two selections are from each other, as JSON.
///
///   {"a":{"names":["house*"]},"b":{"nodes":[7]},"max_distance":2,"pairs":"triangles","limit":100}
///
/// "a" and "b" choose as "include" of rays does. "pairs": "closest" (the default), "triangles" or
/// "nodes", the latter with a "max_distance" (scene units; null, the default, for none); "limit":
/// of pairs listed (1000). "include", "exclude" and "work" as for rays, the first two for both.

#include <string>

#include "core/query/clearance.h"
#include "proto/json/hit_json.h"
#include "proto/json/ray_json.h"

namespace sightline {

struct ClearanceQuery {
  TriangleChoice a, b;
  ClearanceQuestion question;
  RayQuery options;  ///< without rays
};

/// `body` and errors as decode_rays, and 422 DISTANCE_NEGATIVE, DISTANCE_MISSING.
Result<ClearanceQuery> decode_clearance(std::string& body, std::uint64_t max_limit);

/// {"pair":{"distance":1.5,"a":{"instance":0,"primitive":0,"triangle":7,"node":"house","mesh":null,
///  "position":[x,y,z]},"b":{...}}}, null where there is none within the distance; of several
/// {"total":2,"pairs":[...]}. `a` and `b`: primitive, triangle, node_name and mesh_name of each.
std::string encode_clearance(const ClearanceAnswer& answer, ClearancePairs pairs, const HitTerms& a,
                             const HitTerms& b);

}  // namespace sightline

// Tests: tests/integration/clearance_test.py
