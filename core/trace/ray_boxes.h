#pragma once
/// Rays against the boxes of a request.

#include <cstddef>

#include "core/query/box_batch.h"
#include "core/query/ray_batch.h"
#include "core/query/ray_box_answers.h"

namespace sightline {

/// Pairs [begin, end) of checked rays and boxes; slots of the same numbers are overwritten, planes
/// if that column has any. Errors: none. Cost: no allocation; some 60 ns for an axis-aligned box.
void answer_ray_boxes(const RayBatch& rays, const BoxBatch& boxes, BoxPairing pairing,
                      std::size_t begin, std::size_t end, RayBoxAnswers& answers);

}  // namespace sightline
