#pragma once
/// Decodes meshes compressed with KHR_draco_mesh_compression. Sources: the text of the extension
/// (Khronos registry) and the bitstream specification of Draco 2.2.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/import/codec/decoded_elements.h"
#include "core/import/input/budget.h"

namespace sightline::gltf {

/// The name of the extension.
inline constexpr const char* kDraco = "KHR_draco_mesh_compression";

/// A decoded mesh.
struct DracoMesh {
  /// Number of points; a point is a vertex with all its attributes.
  std::uint64_t points = 0;
  std::vector<std::uint32_t> corners;  ///< three points per triangle, each below `points`
  /// by Draco's id of the attribute, one element per point
  std::map<std::uint32_t, DecodedElements> attributes;
};

/// What the glTF file states about the compressed mesh. The compressed bytes must agree.
struct DracoClaim {
  std::uint64_t triangles = 0;
  std::uint64_t points = 0;
  /// Ids of the attributes to decode. Another attribute is decoded only if one of these follows it
  /// in the stream.
  std::vector<std::uint32_t> attributes;
};

/// Decodes a Draco mesh. Before the decoder allocates memory, the function checks that the sizes in
/// the compressed bytes agree with `claim`, that so few bytes can hold them, and that `budget`
/// allows the decoder's memory. Afterwards the budget gets back what only the decoder needed.
/// `place` and `pointer` name the primitive in errors. Errors: GLTF_COMPRESSION_INVALID,
/// GLTF_LIMIT_GEOMETRY_BYTES. Throws std::bad_alloc.
Result<DracoMesh> decode_draco(std::span<const std::byte> compressed, const DracoClaim& claim,
                               Budget& budget, const std::string& place,
                               const std::string& pointer);

}  // namespace sightline::gltf
