#pragma once
/// The triangles of a scene for drawing.

#include <cstdint>

#include "core/scene/scene.h"
#include "proto/binary/geometry_binary.h"

namespace sightline {

/// Which meshes an answer has: in the order of their largest placement, from number `first` on, as
/// many as fit into `max_bytes`; at least one unless that is 0. A mesh is never cut.
struct GeometryRange {
  std::uint64_t first = 0;
  std::uint64_t max_bytes = std::uint64_t{16} << 20;
};

/// Has views of the scene, which outlives it. What is hidden, or has no finite triangle, is not in
/// it. Meshes with the same content are one mesh.
GeometryAnswer scene_geometry(const Scene& scene, const GeometryRange& range);
/// The memory that scene_geometry takes, from above, without its answer as bytes.
std::uint64_t bytes_of_geometry_lists(const Scene& scene);
/// The bytes of an answer, from above.
std::uint64_t bytes_of_geometry(const GeometryAnswer& answer);

}  // namespace sightline
