// The GLB container alone: chunks that lie where the lengths say, or an error.
// Run:  scripts/stress.sh fuzz --target glb_fuzz

#include <cstdint>
#include <cstring>
#include <span>

#include "core/import/gltf/glb_container.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

namespace {

/// Whether `part` is `size` bytes of `whole` behind a chunk header that says so.
bool is_chunk(std::span<const std::byte> whole, std::span<const std::byte> part,
              std::uint32_t type) {
  if (part.data() < whole.data() + 20) return false;
  const auto at = static_cast<std::size_t>(part.data() - whole.data());
  if (at > whole.size() || part.size() > whole.size() - at || part.size() % 4 != 0) return false;
  std::uint32_t header[2];
  std::memcpy(header, whole.data() + at - 8, sizeof header);
  return header[0] == part.size() && header[1] == type;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  if (!gltf::has_glb_magic(bytes)) return 0;
  const auto chunks = gltf::split_glb(bytes);
  if (!chunks) {
    fuzz::require(chunks.error().code == "GLTF_CONTAINER_INVALID" ||
                      chunks.error().code == "GLTF_VERSION_UNSUPPORTED",
                  "errors have a code");
    return 0;
  }
  fuzz::require(!chunks->json.empty() && is_chunk(bytes, chunks->json, 0x4e4f534a),
                "the JSON is the first chunk");
  if (chunks->binary.has_value()) {
    fuzz::require(is_chunk(bytes, *chunks->binary, 0x004e4942), "the BIN chunk is one");
    fuzz::require(chunks->binary->data() == chunks->json.data() + chunks->json.size() + 8,
                  "the BIN chunk is the second");
  }
  fuzz::require(chunks->bytes_after_end < size, "the end lies in the file");
  return 0;
}
