#pragma once
/// Which placements are better off in one tree of the world than in trees of their own.

#include <cstdint>
#include <span>
#include <vector>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Indices of the placements that share one tree in world space, ascending; none if one tree cannot
/// hold them. `placed` are the bounds of their finite world triangles; an empty one is never
/// chosen.
///
/// Every placement of a mesh that is placed once is chosen. Meshes that are placed more often are
/// chosen as a whole, cheapest first, while their copies are few. The limit is the number of
/// triangles that the scene has anyway, or kFreeCopies if that is more.
///
/// Coordinates must be of similar size, so that one scale serves all. A placement is left out if
/// its largest coordinate is beyond 2^40 times, or below 2^-40 times, the median
/// (docs/explanation/exactness.md, "Boxes").
std::vector<std::uint32_t> choose_joined(std::span<const MeshView> meshes,
                                         std::span<const PlacementView> placements,
                                         std::span<const Box3d> placed);

/// Triangles, at some 90 bytes each.
inline constexpr std::uint64_t kFreeCopies = 1u << 20;

}  // namespace sightline
