#pragma once
/// Boxes against a scene, as JSON.
///
///   {"boxes":[...],"of":"triangles","mode":"intersecting","limit":1000}
///
/// boxes as box_rows.h reads them. "of": what is counted and listed, "triangles" (the default) or
/// "nodes"; "mode": those that touch the box (the default) or those that are "contained" in it;
/// "limit": how many of each box are listed (1000). "timeout_ms" as for rays.

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

struct BoxJsonRules {
  FindCamera find_camera = {};  ///< for views; null: there is no scene
  std::size_t max_boxes = 1'000'000;
  bool has_targets = true;           ///< whether "of" may stand there
  bool has_limit = true;             ///< the same for "limit"
  std::uint64_t limit = 10'000'000;  ///< the largest limit that may be asked for
};

struct BoxQuery {
  BoxBatch boxes;        ///< checked by check_boxes
  BoxQuestion question;  ///< where lists begin is not filled in: a cursor may be of another scene
  Column<ListCursor> cursors;  ///< of each box, or none at all
  /// For each box a hash of the box and the mode, where lists may continue: a cursor must come from
  /// an equal one.
  Column<std::uint64_t> questions;
  std::uint64_t limit = 1000;               ///< may be more than the rules' when left out
  std::optional<std::uint64_t> timeout_ms;  ///< the answer may take no longer
};

/// As decode_rays for the body. Errors: those of boxes (box_rows.h), VALUE_UNKNOWN (of, mode),
/// NUMBER_OUT_OF_RANGE (limit).
Result<BoxQuery> decode_boxes(std::string& body, const BoxJsonRules& rules);

/// {"results":[{"total":2,"triangles":[{"instance":0,"primitive":0,"triangle":7,"node":"house",
///                                       "mesh":"walls"},..]}]}
/// or, of nodes, {"results":[{"total":1,"nodes":[{"node":"house","node_id":3}]}]}; total is more
/// than the list holds where the limit cut it, and "next" then the cursor to go on with. In the
/// order of ids.
/// terms     of each entry of the lists: primitive, triangle, node_name and mesh_name of triangles,
///           node and node_name of nodes
/// revision  of the scene
/// questions  BoxQuery::questions
std::string encode_box_lists(const BoxLists& lists, std::span<const std::uint64_t> totals,
                             BoxTargets targets, const HitTerms& terms, std::uint64_t revision,
                             std::span<const std::uint64_t> questions);

}  // namespace sightline
