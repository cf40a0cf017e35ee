#pragma once
/// The triangles of a scene for drawing.

#include <cstdint>
#include <optional>

#include "core/scene/scene.h"
#include "proto/binary/geometry_binary.h"

namespace sightline {

/// Which meshes an answer has. Meshes are in the order of the size of their largest placement,
/// largest first; with `eye` size is the diagonal divided by the distance from the eye, and
/// placements around the eye come first. The answer has those from number `first` on that fit into
/// `max_bytes`, and at least one unless max_bytes is 0. A mesh is never divided.
struct GeometryRange {
  std::uint64_t first = 0;
  std::uint64_t max_bytes = std::uint64_t{16} << 20;
  std::optional<Vec3d> eye;
};

/// Returns views of the scene, which must outlive the answer. Hidden placements, and those without
/// a finite triangle, are left out. Meshes with the same content are one mesh.
GeometryAnswer scene_geometry(const Scene& scene, const GeometryRange& range);
/// An upper bound of the memory that scene_geometry allocates, without the encoded answer.
std::uint64_t bytes_of_geometry_lists(const Scene& scene);
/// An upper bound of the bytes of the encoded answer.
std::uint64_t bytes_of_geometry(const GeometryAnswer& answer);

}  // namespace sightline

// Tests: tests/integration/geometry_test.py
