#pragma once
/// Decodes questions about rays and boxes of one request, and encodes their answers, as JSON.
///
///   {"rays":[...],"boxes":[...],"pairing":"each","line":false,"planes":false}
///
/// "rays": ray_json.h, as rows or columns. "boxes": box_rows.h. "pairing": "each" (default), ray i
/// with box i, or "all", every ray with every box. "line": true: a ray without tmin has no lower
/// limit, so that hits behind its origin count. "planes": true: the answer has the t of all six
/// planes.

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/query/box_batch.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

namespace sightline {

/// What a body may contain.
struct RayBoxJsonRules {
  std::size_t max_rays = 10'000'000;
  std::size_t max_boxes = 1'000'000;
  /// for both pairings; an answer has about 200 bytes for each pair
  std::size_t max_pairs = 1'000'000;
};

/// A decoded question.
struct RayBoxQuery {
  RayBatch rays;   ///< checked by check_rays
  BoxBatch boxes;  ///< checked by check_boxes
  BoxPairing pairing = BoxPairing::kEach;
  bool planes = false;
  std::optional<std::uint64_t> timeout_ms;  ///< the client's limit of the time for the answer
  int threads = 0;                          ///< the client's limit of threads; 0: no limit
};

/// Decodes a body; its text and its capacity are treated as by decode_rays. Errors: those of
/// decode_rays for rays, those of boxes (box_rows.h), 422 VALUE_UNKNOWN (pairing), PAIRS_UNEQUAL
/// (each, with unequal numbers of rays and boxes), 413 PAIRS_TOO_MANY.
Result<RayBoxQuery> decode_ray_boxes(std::string& body, const RayBoxJsonRules& rules);

/// Encodes one result for each slot of the answers (kAll: all boxes for the first ray, then for the
/// second):
/// {"results":[{"hit":true,"t":8,"t_enter":8,"t_exit":14,"inside":false,"on_surface":false,
///              "face":"-x","faces":["-x"],"normal":[-1,0,0]},
///             {"hit":false,"miss":["x","y"]},
///             {"hit":false,"miss":"behind","t_enter":-12,"t_exit":-6,"inside":false,
///              "on_surface":false}]}
/// miss        the two slabs that exclude each other, or the slab that the ray runs outside of;
///             "behind" or "beyond" if the line meets the box before or after the limits
/// t, t_enter, t_exit  null if the box is open there, or the number exceeds float64; t, face and
///             normal are null if the ray ends inside
/// planes      if requested: the t of -x +x -y +y -z +z; null if parallel or open
std::string encode_ray_boxes(const RayBoxAnswers& answers);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
