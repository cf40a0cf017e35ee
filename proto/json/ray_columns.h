#pragma once
/// Rays as an answer: what a generator makes, to be read by people or sent back.

#include <string>

#include "core/query/ray_batch.h"

namespace sightline {

/// {"origins":[x,y,z,...],"directions":[...],"tmin":[...],"tmax":[...]}, null for no tmax: a body
/// that decode_rays reads as the same rays.
std::string encode_ray_columns(const RayBatch& rays);
/// The rays as a body for decode_rays_binary, in float64.
std::string encode_rays_binary(const RayBatch& rays);

}  // namespace sightline

// Tests: tests/integration/generators_test.py
