#pragma once
/// Pairs of points as JSON, and what stands between them.
///
///   {"from":[[x,y,z],...],"to":[[x,y,z],...],"pairing":"all","ends":"open","first_blocker":true,
///    "fields":["t","node"]}
///
/// "pairing": "all" (every from with every to) or "each"; "ends": "open" or "closed"; "fields" of
/// blockers; "cull", "include", "exclude" and "work" as for rays.

#include <string>

#include "core/query/point_pairs.h"
#include "proto/json/ray_json.h"

namespace sightline {

struct VisibilityQuery {
  PointPairs pairs;  ///< checked by check_pairs
  bool first_blocker = false;
  RayQuery options;  ///< without rays
};

/// `body` as decode_rays takes it. Errors: as decode_rays, and 422 PAIRS_UNEQUAL, POINTS_TOO_FAR (a
/// difference that overflows), FIELDS_WITHOUT_BLOCKER; 413 PAIRS_TOO_MANY.
Result<VisibilityQuery> decode_visibility(std::string& body, std::size_t max_pairs);

/// {"visible":["101","011"]}, a text of 0 and 1 for each from; for "each" one text. With blockers
/// also "blockers":[[hit,null,hit],...], or for "each" one such list.
/// blockers, details, terms   none (null, empty) unless they were asked for
std::string encode_visibility(const VisibilityQuery& query, std::span<const std::uint8_t> visible,
                              const HitBatch* blockers, std::span<const HitDetail> details,
                              const HitTerms& terms);

}  // namespace sightline

// Tests: tests/integration/visibility_test.py
