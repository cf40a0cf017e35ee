#pragma once
/// Encodes answers to rays as JSON.

#include <cstdint>
#include <span>
#include <string>

#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"
#include "proto/json/json_writer.h"

namespace sightline {

/// Writes the members that name a triangle, without brackets: "instance", "primitive", "triangle",
/// "node", "mesh". `i` is its slot in `terms`.
void write_triangle_members(JsonWriter& out, std::uint32_t instance, const HitTerms& terms,
                            std::size_t i);

/// Encodes one hit for each ray: {"hits":[..]} as rows, or columns. See AnswerLayout.
/// hits     n slots
/// details  n slots; empty if no field of kDetailFields is in `fields`
/// terms    columns of n slots for the requested fields
/// layout   kRows or kColumns
/// A column of vectors has 3n numbers (barycentrics 2n). A miss is null in rows; in columns it is
/// null, or -1 in a column of ids.
std::string encode_hits(const HitBatch& hits, std::span<const HitDetail> details,
                        const HitTerms& terms, FieldSet fields, AnswerLayout layout);

/// Encodes one hit as an object, for a command line; `i` is its slot. A miss is null.
std::string encode_hit(const HitBatch& hits, std::span<const HitDetail> details,
                       const HitTerms& terms, FieldSet fields, std::size_t i);

/// Encodes a list of hits for each ray, with its total, which is larger than the list if max_hits
/// cut it.
/// rows     {"results":[{"total":2,"hits":[{"t":5},{"t":6}]},{"total":0,"hits":[]}]}
/// columns  {"totals":[2,0],"first":[0,2,2],"t":[5,6]}: ray i has the hits first[i] .. first[i+1]
/// totals   one number for each ray
/// details, terms  one slot for each hit of lists.hits
/// layout   kRows or kColumns
std::string encode_hit_lists(const HitLists& lists, std::span<const std::uint64_t> totals,
                             std::span<const HitDetail> details, const HitTerms& terms,
                             FieldSet fields, AnswerLayout layout);

/// Encodes the nearest triangles of points: {"results":[{"hits":[{"distance":5},..]},..]}.
std::string encode_nearest_lists(const HitLists& lists, std::span<const HitDetail> details,
                                 const HitTerms& terms, FieldSet fields);

/// Encodes {"counts":[2,0]}, which rows and columns have in common.
std::string encode_counts(std::span<const std::uint64_t> counts);

/// Encodes {"hits":[true,false]}; 0 is false.
std::string encode_occlusion(std::span<const std::uint8_t> occluded);

}  // namespace sightline
