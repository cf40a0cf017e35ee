#pragma once
/// Rows of the contract's table that aim at any scene, ray by ray.

#include <span>
#include <string_view>

#include "tests/stress/aims.h"

namespace sightline::stress {

struct AimedFamily {
  std::string_view name;
  Ray (*ray)(const Aim& aim);  ///< the next one from the aim's random source
};

/// vertex_aims, edge_aims, near_edges_float64, origin_on_surface, in_a_triangles_plane, grazing,
/// origin_far_away.
std::span<const AimedFamily> aimed_families();
/// Precondition: the name is one of the list.
const AimedFamily& aimed_family(std::string_view name);

/// A corner, a point of an edge or an inner point.
Vec3d any_target(const Aim& aim);

}  // namespace sightline::stress
