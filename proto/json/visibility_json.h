#pragma once
/// Decodes questions about visibility between points, and encodes their answers, as JSON.
///
///   {"from":[[x,y,z],...],"to":[[x,y,z],...],"pairing":"all","ends":"open","first_blocker":true,
///    "fields":["t","node"]}
///
/// "pairing": "all" (every from with every to) or "each". "ends": "open" or "closed"
/// (core/query/point_pairs.h). "fields": of blockers. "cull", "include", "exclude" and "work": as
/// for rays.

#include <string>

#include "core/query/point_pairs.h"
#include "proto/json/ray_json.h"

namespace sightline {

/// A decoded question.
struct VisibilityQuery {
  PointPairs pairs;  ///< checked by check_pairs
  bool first_blocker = false;
  QueryOptions options;
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays, 422 PAIRS_UNEQUAL, POINTS_TOO_FAR (a difference overflows), FIELDS_WITHOUT_BLOCKER,
/// 413 PAIRS_TOO_MANY. max_pairs: the most pairs, for both pairings.
Result<VisibilityQuery> decode_visibility(std::string& body, std::size_t max_pairs);

/// Encodes {"visible":["101","011"]}: for each `from` a text with 1 for each visible `to`; with
/// "each" one text. If blockers were requested, also "blockers":[[hit,null,hit],...], or with
/// "each" one such list. Without a request, `blockers` is null, and `details` and `terms` are
/// empty.
std::string encode_visibility(const VisibilityQuery& query, std::span<const std::uint8_t> visible,
                              const HitBatch* blockers, std::span<const HitDetail> details,
                              const HitTerms& terms);

}  // namespace sightline

// Tests: tests/integration/visibility_test.py
