#pragma once
/// Encodes generated rays as an answer, which a client can read or send back as a request.

#include <string>

#include "core/query/ray_batch.h"

namespace sightline {

/// Encodes {"origins":[x,y,z,...],"directions":[...],"tmin":[...],"tmax":[...]}, with null for an
/// infinite tmax. decode_rays reads the same rays from it.
std::string encode_ray_columns(const RayBatch& rays);
/// Encodes the rays as a body for decode_rays_binary, in float64, with tmin and tmax.
std::string encode_rays_binary(const RayBatch& rays);

}  // namespace sightline

// Tests: tests/integration/generators_test.py
