#pragma once
/// Answers a camera with a picture of what its rays hit.

#include <string>

#include "core/base/deadline.h"
#include "core/base/result.h"
#include "server/service/ray_answer.h"

namespace sightline {

/// Returns the bytes of the picture file. Makes, traces and draws some rows at a time, so that
/// memory grows with the picture alone. Precondition: query.image and query.camera have values.
/// Errors: those of the engine, of generate_rows, of HitImageEncoder, of options.reserve, and of
/// within_memory. Adds times to timer.report.
Result<std::string> answer_image(const Service& service, const Scene& scene, const RayQuery& query,
                                 const RayOptions& options, const Deadline& deadline,
                                 WorkTimer& timer);

}  // namespace sightline

// Tests: tests/integration/images_test.py
