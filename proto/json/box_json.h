#pragma once
/// Decodes questions about boxes in a scene, and encodes their answers, as JSON.
///
///   {"boxes":[...],"of":"triangles","mode":"intersecting","limit":1000}
///
/// "boxes": box_rows.h. "of": what is counted and listed, "triangles" (default) or "nodes". "mode":
/// "intersecting" (default), those that touch the box, or "contained", those that lie in it.
/// "limit": the most entries of each list (1000). "contacts": true, for lists of triangles: how deep
/// the shape is in each, and the direction in which it comes out; not for planes, corners and views. "timeout_ms", "threads": as for rays.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/query/box_answers.h"
#include "core/query/box_batch.h"
#include "proto/file_camera.h"
#include "proto/json/hit_json.h"
#include "proto/json/list_cursor.h"

namespace sightline {

/// What a body may contain.
struct BoxJsonRules {
  FindCamera find_camera = {};  ///< for views; null: there is no scene
  std::size_t max_boxes = 1'000'000;
  bool has_targets = true;           ///< true: "of" is allowed
  bool has_limit = true;             ///< true: "limit" is allowed
  std::uint64_t limit = 10'000'000;  ///< the largest limit that is accepted
};

/// A decoded question.
struct BoxQuery {
  BoxBatch boxes;              ///< have passed check_boxes
  BoxQuestion question;        ///< without `from`, which the caller sets after checking the cursors
  Column<ListCursor> cursors;  ///< one for each box, or empty
  /// For questions whose lists may continue: a hash of each box and the mode. A cursor is accepted
  /// only if its hash is equal.
  Column<std::uint64_t> questions;
  std::uint64_t limit = 1000;               ///< the default may exceed the rules' limit
  std::optional<std::uint64_t> timeout_ms;  ///< the client's limit of the time for the answer
  int threads = 0;                          ///< the client's limit of threads; 0: no limit
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of a body
/// (JSON_MALFORMED, KEY_ and TYPE_ errors), those of boxes (box_rows.h), VALUE_UNKNOWN (of, mode),
/// NUMBER_OUT_OF_RANGE (limit), KEYS_MIXED and BOX_CONTACTS (contacts).
Result<BoxQuery> decode_boxes(std::string& body, const BoxJsonRules& rules);

/// Encodes lists, sorted by ids:
/// {"results":[{"total":2,"triangles":[{"instance":0,"primitive":0,"triangle":7,"node":"house",
///                                       "mesh":"walls"},..]}]}
/// or, for nodes, {"results":[{"total":1,"nodes":[{"node":"house","node_id":3}]}]}. If a list is
/// cut, `total` is larger than its size, and "next" is a cursor for the rest.
/// lists      one list for each box
/// totals     for each box the number of all entries
/// terms      of each entry of all lists: primitive, triangle, node_name and mesh_name for
///            triangles, node and node_name for nodes
/// revision   revision of the scene, for the cursors
/// questions  BoxQuery::questions
/// contacts   of each triangle of all lists, or null. With it a triangle has "depth" and
///            "contact_normal" too, which are null if no translation separates both.
std::string encode_box_lists(const BoxLists& lists, std::span<const std::uint64_t> totals,
                             BoxTargets targets, const HitTerms& terms, std::uint64_t revision,
                             std::span<const std::uint64_t> questions,
                             const BoxContacts* contacts = nullptr);

}  // namespace sightline
