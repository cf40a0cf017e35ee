#pragma once
/// MeshoptView: a bufferView that is compressed with EXT_meshopt_compression, and its decoding.
/// Source: the text of the extension (Khronos registry).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"

namespace sightline::gltf {

/// The name of the extension.
inline constexpr const char* kMeshopt = "EXT_meshopt_compression";

/// The modes and filters of the extension, by their names in its text.
enum class MeshoptMode : std::uint8_t { kAttributes, kTriangles, kIndices };
enum class MeshoptFilter : std::uint8_t { kNone, kOctahedral, kQuaternion, kExponential };

/// A compressed bufferView as the file states it. Decoding gives `count` elements of `stride`
/// bytes.
struct MeshoptView {
  /// where the compressed bytes are: index of the buffer, first byte, number of bytes
  std::uint64_t buffer = 0, offset = 0, length = 0;
  std::uint64_t count = 0, stride = 0;
  MeshoptMode mode = MeshoptMode::kAttributes;
  MeshoptFilter filter = MeshoptFilter::kNone;

  std::uint64_t decoded_bytes() const { return count * stride; }
};

/// Returns the rule of the extension that this combination of stride, count, mode and filter
/// breaks, or nullptr. The decoders assert these rules, so a caller must check them before
/// decoding.
const char* broken_rule(const MeshoptView& view);

/// The fewest bytes to which `count` elements can be compressed. A caller checks that the file has
/// so many before it allocates memory. The decoded bytes are at most 64 times as many.
std::uint64_t fewest_bytes(const MeshoptView& view);

/// Decodes `compressed`, and returns exactly view.decoded_bytes() bytes. `place` and `pointer` name
/// the view in errors. Preconditions: broken_rule(view) is nullptr; decoded_bytes() is within the
/// budget of the caller. Errors: GLTF_COMPRESSION_INVALID. Throws std::bad_alloc.
Result<std::unique_ptr<std::byte[]>> decode_meshopt(const MeshoptView& view,
                                                    std::span<const std::byte> compressed,
                                                    const std::string& place,
                                                    const std::string& pointer);

}  // namespace sightline::gltf
