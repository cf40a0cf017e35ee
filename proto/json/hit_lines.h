#pragma once
/// Encodes answers to rays as lines of JSON, one for each ray in order. The line of a ray that is
/// marked as invalid is {"invalid":"RAY_DIRECTION_ZERO"}.

#include <span>
#include <string>

#include "core/query/ray_batch.h"
#include "proto/json/hit_json.h"

namespace sightline {

/// The media type of lines of JSON.
inline constexpr std::string_view kLinesMediaType = "application/x-ndjson";

// Line forms of the functions of hit_json.h, with the same parameters. `invalid`: the rays that are
// marked as invalid; null if the client did not ask for marks.

/// Lines like {"t":5,"triangle":12}, or null for a miss.
std::string encode_hit_lines(const HitBatch& hits, std::span<const HitDetail> details,
                             const HitTerms& terms, FieldSet fields, const InvalidRays* invalid);
/// Lines like {"total":2,"hits":[{"t":5},{"t":6}]}.
std::string encode_hit_list_lines(const HitLists& lists, std::span<const std::uint64_t> totals,
                                  std::span<const HitDetail> details, const HitTerms& terms,
                                  FieldSet fields, const InvalidRays* invalid);
/// Lines like 2.
std::string encode_count_lines(std::span<const std::uint64_t> counts, const InvalidRays* invalid);
/// Lines like true.
std::string encode_occlusion_lines(std::span<const std::uint8_t> occluded,
                                   const InvalidRays* invalid);

}  // namespace sightline

// Tests: tests/integration/streams_test.py
