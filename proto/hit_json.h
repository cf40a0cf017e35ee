#pragma once
/// Answers to rays as JSON.

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/column.h"
#include "core/query/hit_batch.h"
#include "proto/hit_fields.h"
#include "proto/json_writer.h"

namespace sightline {

enum class AnswerLayout {
  kRows,     ///< {"hits":[{"t":5,"triangle":12}, null]}
  kColumns,  ///< {"t":[5,null],"triangle":[12,-1]}
  kBinary,   ///< the same as bytes: hit_binary.h
  kImage,    ///< a picture: hit_image.h
  kLines,    ///< {"t":5,"triangle":12}\nnull\n: hit_lines.h
};

/// What hits mean in the file's own terms and units. Columns of n slots, one for each hit; a column
/// whose field is not asked for may be empty. Numbers that do not apply are kNone, names that the
/// file does not give are empty. Names live elsewhere, as long as the scene.
struct HitTerms {
  Column<std::uint32_t> primitive, triangle, node, mesh, material;
  std::vector<std::string_view> node_name, node_path, mesh_name, material_name;
  HitAttributes attributes;
  Column<double> distance;     ///< t * |direction|
  bool t_is_distance = false;  ///< what stands as t is the distance too
  Column<std::uint32_t> visits;  ///< of a picture: boxes that each ray was tested with
  /// that node_path refers to; moving this struct moves none of them
  std::deque<std::string> own_texts;
};

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
