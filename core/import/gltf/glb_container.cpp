#include "core/import/gltf/glb_container.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::uint32_t kMagic = 0x46546c67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004e4942;   // "BIN\0"

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  }
  return value;
}

Error broken(std::string message) {
  return malformed("GLTF_CONTAINER_INVALID", "GLB: " + std::move(message));
}

/// Whether a BIN chunk that fits begins at `at`.
bool continues_at(std::span<const std::byte> file, std::size_t at) {
  return file.size() - at >= 8 && u32_at(file, at + 4) == kBinChunk &&
         u32_at(file, at) <= file.size() - at - 8;
}

/// Where the chunk begins that follows a chunk of `size` bytes at `at`; empty if that is not clear.
std::optional<std::size_t> next_chunk(std::span<const std::byte> file, std::size_t at,
                                      std::size_t size) {
  const std::size_t here = at + size;
  if (size % 4 == 0) return here;
  const std::size_t padded = here + (4 - size % 4);
  // Padding is at most 3 bytes: the file ends here by either reading.
  if (padded >= file.size()) return file.size();
  // Not both: two names of chunks less than 4 bytes apart would overlap.
  for (const std::size_t next : {here, padded}) {
    if (continues_at(file, next)) return next;
  }
  return std::nullopt;
}

}  // namespace

bool has_glb_magic(std::span<const std::byte> bytes) {
  return bytes.size() >= 4 && u32_at(bytes, 0) == kMagic;
}

Result<GlbChunks> split_glb(std::span<const std::byte> bytes) {
  if (bytes.size() < 12) {
    return broken("the header needs 12 bytes, the file has " + std::to_string(bytes.size()));
  }
  const std::uint32_t version = u32_at(bytes, 4), length = u32_at(bytes, 8);
  if (version != 2) {
    return Error{ErrorKind::kUnsupported, "GLTF_VERSION_UNSUPPORTED",
                 "GLB: container version " + std::to_string(version) + ", only 2 is known", ""};
  }
  if (length > bytes.size()) {
    return broken("the header states " + std::to_string(length) + " bytes, the file has " +
                  std::to_string(bytes.size()));
  }
  GlbChunks chunks;
  chunks.bytes_after_end = bytes.size() - length;

  // Chunk by chunk: JSON first, BIN second or not at all, anything else is for others.
  std::size_t at = 12;
  for (std::size_t number = 0; at < length; ++number) {
    if (length - at < 8) {
      return broken("chunk " + std::to_string(number) + " at byte " + std::to_string(at) +
                    " needs a header of 8 bytes, " + std::to_string(length - at) + " are left");
    }
    const std::uint32_t size = u32_at(bytes, at), type = u32_at(bytes, at + 4);
    at += 8;
    if (size > length - at) {
      return broken("chunk " + std::to_string(number) + " states " + std::to_string(size) +
                    " bytes, " + std::to_string(length - at) + " are left");
    }
    const auto payload = bytes.subspan(at, size);
    if (number == 0) {
      if (type != kJsonChunk) return broken("the first chunk is not JSON");
      chunks.json = payload;
    } else if (number == 1 && type == kBinChunk) {
      chunks.binary = payload;
    }
    const auto next = next_chunk(bytes.first(length), at, size);
    if (!next) {
      return broken("chunk " + std::to_string(number) + " has " + std::to_string(size) +
                    " bytes, not a multiple of 4, and it is not clear where the next one begins");
    }
    if (size % 4 != 0) chunks.unaligned_chunk = number;
    at = *next;
  }
  if (chunks.json.empty()) return broken("there is no JSON");
  return chunks;
}

}  // namespace sightline::gltf
