#pragma once
/// Encodes answers to rays as bytes: docs/reference/binary.md.

#include <span>
#include <string>

#include "core/query/ray_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"

namespace sightline {

/// Checks that `fields` has no field of text, and `named` no long name, which binary answers cannot
/// have. Errors: FIELD_IS_TEXT and FIELD_NAME_LONG, naming the first one.
Status check_binary_fields(FieldSet fields, std::span<const std::string> named);

// Binary forms of the functions of hit_json.h, with the same parameters. Precondition:
// check_binary_fields accepts `fields`; texts would be left out. `invalid`: the rays that are
// marked as invalid; null if the client did not ask for marks.

std::string encode_hits_binary(const HitBatch& hits, std::span<const HitDetail> details,
                               const HitTerms& terms, FieldSet fields, const InvalidRays* invalid);
std::string encode_hit_lists_binary(const HitLists& lists, std::span<const std::uint64_t> totals,
                                    std::span<const HitDetail> details, const HitTerms& terms,
                                    FieldSet fields, const InvalidRays* invalid);
std::string encode_nearest_lists_binary(const HitLists& lists, std::span<const HitDetail> details,
                                        const HitTerms& terms, FieldSet fields);
std::string encode_counts_binary(std::span<const std::uint64_t> counts, const InvalidRays* invalid);
std::string encode_occlusion_binary(std::span<const std::uint8_t> occluded,
                                    const InvalidRays* invalid);

}  // namespace sightline

// Tests: tests/unit/proto/ray_binary_test.cpp
