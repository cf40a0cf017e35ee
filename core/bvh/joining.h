#pragma once
/// Chooses which placements share one tree in world space, and which have trees of their own.

#include <cstdint>
#include <span>
#include <vector>

#include "core/bvh/scene_tree.h"

namespace sightline {

/// Returns the indices of the placements that should share one tree in world space, ascending;
/// empty if one tree cannot hold them. `placed` are the bounds of the finite world triangles of
/// each placement (ScenePlan::placed); a placement with empty bounds is never chosen. Throws
/// std::bad_alloc.
///
/// Every placement of a mesh that is placed once is chosen. For a mesh that is placed more often,
/// all its placements are chosen or none: the tree needs a copy of the triangles for each. Meshes
/// with the fewest copied triangles are chosen first. The limit of copies is the number of
/// triangles of the scene's meshes, or kFreeCopies if that is more. The tree has at most
/// `tree_triangles` in all.
///
/// Coordinates must be of similar size, so that one scale serves all. A placement is left out if
/// its largest coordinate is beyond 2^40 times, or below 2^-40 times, the median of all placements'
/// largest coordinates (docs/explanation/exactness.md, "Boxes").
std::vector<std::uint32_t> choose_joined(std::span<const MeshView> meshes,
                                         std::span<const PlacementView> placements,
                                         std::span<const Box3d> placed,
                                         std::uint32_t tree_triangles = kTreeTriangles);

/// The number of copied triangles that is always allowed; each takes 35 to 56 bytes.
inline constexpr std::uint64_t kFreeCopies = 1u << 20;

}  // namespace sightline
