#pragma once
/// A bufferView that EXT_meshopt_compression fills, and the decoding of its bytes.
/// Source: the extension's own text (EXT_meshopt_compression, Khronos registry).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"

namespace sightline::gltf {

inline constexpr const char* kMeshopt = "EXT_meshopt_compression";

enum class MeshoptMode : std::uint8_t { kAttributes, kTriangles, kIndices };
enum class MeshoptFilter : std::uint8_t { kNone, kOctahedral, kQuaternion, kExponential };

/// A compressed view as the file states it; `count` elements of `stride` bytes come out.
struct MeshoptView {
  std::uint64_t buffer = 0, offset = 0, length = 0;  ///< of the compressed bytes
  std::uint64_t count = 0, stride = 0;
  MeshoptMode mode = MeshoptMode::kAttributes;
  MeshoptFilter filter = MeshoptFilter::kNone;

  std::uint64_t decoded_bytes() const { return count * stride; }
};

/// The rule of the extension that the combination of stride, count, mode and filter breaks, or
/// nullptr. The decoders assert these rules, so all of them must be checked.
const char* broken_rule(const MeshoptView& view);

/// The fewest bytes that `count` elements can be compressed to: what must be there before anything
/// is allocated for them. It bounds the decoded bytes by 64 times the compressed ones.
std::uint64_t fewest_bytes(const MeshoptView& view);

/// Exactly view.decoded_bytes() bytes. Preconditions: broken_rule(view) is nullptr, and
/// decoded_bytes() is what the caller can spare.
/// Errors: GLTF_COMPRESSION_INVALID naming `place`.
Result<std::unique_ptr<std::byte[]>> decode_meshopt(const MeshoptView& view,
                                                    std::span<const std::byte> compressed,
                                                    const std::string& place,
                                                    const std::string& pointer);

}  // namespace sightline::gltf
