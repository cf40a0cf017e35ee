#pragma once
/// The decoding of KHR_draco_mesh_compression. Source: the extension's own text (Khronos registry)
/// and the bitstream of Draco 2.2.

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

inline constexpr const char* kDraco = "KHR_draco_mesh_compression";

struct DracoMesh {
  std::uint64_t points = 0;
  std::vector<std::uint32_t> corners;  ///< three points per triangle, each below `points`
  std::map<std::uint32_t, DecodedElements> attributes;  ///< by id, one element per point
};

/// The counts that the file states beside the compressed bytes; they must agree.
struct DracoClaim {
  std::uint64_t triangles = 0;
  std::uint64_t points = 0;
  std::vector<std::uint32_t> attributes;  ///< ids that are wanted; others are decoded only when one
                                          ///< of these stands behind them
};

/// Decodes a Draco mesh. Nothing is allocated before three checks: the sizes in the compressed
/// bytes agree with the claim, they are possible for so few bytes, and the decoder's memory is in
/// the budget. Memory that only the decoder needed is returned to the budget afterwards. Errors:
/// GLTF_COMPRESSION_INVALID naming `place`, GLTF_LIMIT_GEOMETRY_BYTES.
Result<DracoMesh> decode_draco(std::span<const std::byte> compressed, const DracoClaim& claim,
                               Budget& budget, const std::string& place,
                               const std::string& pointer);

}  // namespace sightline::gltf
