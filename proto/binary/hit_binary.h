#pragma once
/// Answers to rays as bytes: docs/reference/binary.md has the table.

#include <span>
#include <string>

#include "core/query/ray_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"

namespace sightline {

/// Whether `fields` can be told without texts. Errors: FIELD_IS_TEXT, naming the first that cannot.
Status check_binary_fields(FieldSet fields);

// The functions of hit_json.h as bytes; columns of texts are left out. `invalid`: the bad rays, or
// null when all rays are good.

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
