#pragma once
/// Rays against the boxes of the same request, as JSON.
///
///   {"rays":[...],"boxes":[...],"pairing":"each","line":false,"planes":false}
///
/// rays as ray_json.h reads them, rows or columns; boxes as box_rows.h does. "each": ray i and box
/// i (the default), "all": every ray and every box. line: a ray without tmin has no lower limit, so
/// that hits behind its origin count (a limit that is given holds). planes: also the six t.

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/query/box_batch.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

namespace sightline {

struct RayBoxJsonRules {
  std::size_t max_rays = 10'000'000;
  std::size_t max_boxes = 1'000'000;
  std::size_t max_pairs = 1'000'000;  ///< of either pairing: an answer is some 200 bytes
};

struct RayBoxQuery {
  RayBatch rays;   ///< checked by check_rays
  BoxBatch boxes;  ///< checked by check_boxes
  BoxPairing pairing = BoxPairing::kEach;
  bool planes = false;
  std::optional<std::uint64_t> timeout_ms;  ///< the answer may take no longer
};

/// Decodes the body as decode_rays does. Errors: those of decode_rays for rays (rows and columns),
/// of boxes (box_rows.h), 422 VALUE_UNKNOWN (pairing), PAIRS_UNEQUAL (each, with unequal numbers of
/// rays and boxes); 413 PAIRS_TOO_MANY.
Result<RayBoxQuery> decode_ray_boxes(std::string& body, const RayBoxJsonRules& rules);

/// {"results":[{"hit":true,"t":8,"t_enter":8,"t_exit":14,"inside":false,"on_surface":false,
///              "face":"-x","faces":["-x"],"normal":[-1,0,0]},
///             {"hit":false,"miss":["x","y"]},
///             {"hit":false,"miss":"behind","t_enter":-12,"t_exit":-6,"inside":false,
///              "on_surface":false}]}
/// One result per slot of the answers (kAll: all boxes of the first ray, then of the second).
/// miss        two slabs that exclude each other, or one that the ray runs beside; "behind" or
///             "beyond" when the line meets the box before or after the limits
/// t, t_enter, t_exit  null where the box is open or the number is beyond float64; t, face and
///             normal are null when the ray ends inside
/// planes      if the answers have them: the t of -x +x -y +y -z +z; null where parallel or open
std::string encode_ray_boxes(const RayBoxAnswers& answers);

}  // namespace sightline

// Tests: tests/unit/proto/box_json_test.cpp
