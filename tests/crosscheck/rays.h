#pragma once
/// Rays of the cross-check. Every component is a float32 number, so that Embree gets the same ray.

#include <cstdint>
#include <span>

#include "core/query/ray_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::crosscheck {

/// 35% camera (four views, row by row), 25% incoherent (uniform origin in the bounds, uniform
/// direction), 20% aimed at corners and 20% aimed at edges, most of these exactly. One in eight has
/// limits. Every ray is one that Embree accepts.
/// Preconditions: at least one triangle is finite, coordinates are far from the float32 limits.
RayBatch mixed_rays(std::span<const oracle::Triangle> triangles, std::size_t count,
                    std::uint64_t seed);

}  // namespace sightline::crosscheck
