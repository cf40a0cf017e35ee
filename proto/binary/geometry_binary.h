#pragma once
/// Encodes the triangles of a scene as bytes, for drawing: docs/reference/binary.md, "Geometry".

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/index_column.h"
#include "core/query/ray_batch.h"

namespace sightline {

/// A mesh to be sent. It refers to the scene, which must outlive it.
struct GeometryMesh {
  /// Index of the mesh in the file.
  std::uint32_t file_mesh = 0;
  Vec3d origin;                      ///< positions are sent as differences from it
  std::span<const Vec3f> positions;  ///< in mesh space
  IndexView indices;                 ///< three for each triangle, into `positions`
};

/// A range of a mesh's triangles with one material.
struct GeometryPart {
  std::uint32_t mesh = 0;  ///< row in GeometryAnswer::meshes
  std::uint32_t first_triangle = 0, triangles = 0;
  /// Index of the primitive in the file's mesh.
  std::uint32_t file_primitive = 0;
  std::uint32_t material = 0xffffffffu;         ///< index in the file; this value: none
  std::array<double, 4> colour = {1, 1, 1, 1};  ///< base colour factor of the material, RGBA
};

/// A placement of a mesh.
struct GeometryPlacement {
  std::uint32_t mesh = 0;          ///< row in GeometryAnswer::meshes
  std::uint32_t instance = 0;      ///< as in hits
  std::uint32_t file_node = 0;     ///< index of the node in the file
  std::array<double, 9> linear{};  ///< rows of the 3x3 matrix from mesh space to world space
  Vec3d at{};                      ///< world position of GeometryMesh::origin
};

/// An answer: the whole geometry or a part of it.
struct GeometryAnswer {
  std::vector<GeometryMesh> meshes;
  std::vector<GeometryPart> parts;
  std::vector<GeometryPlacement> placements;
  std::uint64_t all_meshes = 0, all_bytes = 0;  ///< totals of the whole scene
  std::optional<std::uint64_t> next;  ///< cursor of the next part; empty if this is the last
};

/// Bytes of one row of each kind of column.
inline constexpr std::uint64_t kPositionBytes = 12, kTriangleBytes = 12, kMeshBytes = 44,
                               kPartBytes = 52, kPlacementBytes = 72;

/// Encodes an answer. Throws std::bad_alloc.
std::string encode_geometry(const GeometryAnswer& answer);

}  // namespace sightline

// Tests: tests/integration/geometry_test.py
