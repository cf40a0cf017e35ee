#pragma once
/// Answers to rays as JSON.

#include <cstdint>
#include <span>
#include <string>

#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/hit_terms.h"
#include "proto/json/json_writer.h"

namespace sightline {

/// The members of an object that name a triangle, without its brackets: "instance", "primitive",
/// "triangle", "node", "mesh". `i` is its slot in `terms`.
void write_triangle_members(JsonWriter& out, std::uint32_t instance, const HitTerms& terms,
                            std::size_t i);

/// hits     n slots
/// details  n slots, or none when no field of kDetailFields is in `fields`
/// terms    columns of n slots for the fields asked for
/// Vectors stand in columns as 3n (barycentrics 2n) numbers. A miss is null in rows; in columns it
/// is null, or -1 where the column holds ids.
std::string encode_hits(const HitBatch& hits, std::span<const HitDetail> details,
                        const HitTerms& terms, FieldSet fields, AnswerLayout layout);

/// One hit as an object, for a command line; `i` is its slot. A miss is null.
std::string encode_hit(const HitBatch& hits, std::span<const HitDetail> details,
                       const HitTerms& terms, FieldSet fields, std::size_t i);

/// Lists of hits, each with the total of its ray, which is more than the list holds where max_hits
/// cut it.
/// rows     {"results":[{"total":2,"hits":[{"t":5},{"t":6}]},{"total":0,"hits":[]}]}
/// columns  {"totals":[2,0],"first":[0,2,2],"t":[5,6]}: the hits of ray i are first[i]..first[i+1]
/// details and terms have one slot for each of lists.hits.
std::string encode_hit_lists(const HitLists& lists, std::span<const std::uint64_t> totals,
                             std::span<const HitDetail> details, const HitTerms& terms,
                             FieldSet fields, AnswerLayout layout);

/// The nearest triangles of points: {"results":[{"hits":[{"distance":5},..]},..]}.
std::string encode_nearest_lists(const HitLists& lists, std::span<const HitDetail> details,
                                 const HitTerms& terms, FieldSet fields);

/// {"counts":[2,0]}, for rows and for columns.
std::string encode_counts(std::span<const std::uint64_t> counts);

/// {"hits":[true,false]}; 0 is false.
std::string encode_occlusion(std::span<const std::uint8_t> occluded);

}  // namespace sightline
