#pragma once
/// Splits the GLB container: a 12-byte header, a JSON chunk, at most one BIN chunk, unknown chunks.

#include <cstddef>
#include <optional>
#include <span>

#include "core/base/result.h"

namespace sightline::gltf {

/// The chunks of a GLB file, as views of the caller's bytes, which must outlive them.
struct GlbChunks {
  std::span<const std::byte> json;                   ///< the text of the JSON chunk
  std::optional<std::span<const std::byte>> binary;  ///< empty: there is no BIN chunk
  /// bytes after the length that the header states, which are ignored
  std::size_t bytes_after_end = 0;
  /// number of a chunk whose length is not a multiple of 4, as the specification demands
  std::optional<std::size_t> unaligned_chunk = {};
};

/// True if the bytes begin with "glTF".
bool has_glb_magic(std::span<const std::byte> bytes);

/// Splits a GLB file. Every length is checked against the bytes. Lengths should be multiples of 4.
/// After another length, the next chunk is a BIN chunk that begins at the next byte, or after
/// padding to a multiple of 4; neither is an error.
/// Precondition: has_glb_magic(bytes).
/// Errors: GLTF_CONTAINER_INVALID, GLTF_VERSION_UNSUPPORTED.
/// Source: [glTF2] 4.4.
Result<GlbChunks> split_glb(std::span<const std::byte> bytes);

}  // namespace sightline::gltf
