#pragma once
/// From a camera to a picture of what its rays hit.

#include <string>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "server/service/ray_answer.h"

namespace sightline {

/// Makes, traces and draws some rows at a time, so that memory grows with the picture alone.
/// Precondition: query.image and query.camera. Errors: those of the engine, of generate_rows, of
/// HitImageEncoder and of options.reserve.
Result<std::string> answer_image(const Service& service, const Scene& scene, const RayQuery& query,
                                 const RayOptions& options, const Deadline& deadline,
                                 WorkTimer& timer);

}  // namespace sightline

// Tests: tests/integration/images_test.py
