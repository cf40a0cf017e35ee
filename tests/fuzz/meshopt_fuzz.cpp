// Bytes of EXT_meshopt_compression: elements or an error, for every mode, filter, stride and count.
// Input: mode and filter, stride, count (little-endian), then the compressed bytes.
// Run:  scripts/stress.sh fuzz --target meshopt_fuzz

#include <cstdint>
#include <span>

#include "core/import/codec/meshopt_view.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  gltf::MeshoptView view;
  view.mode = static_cast<gltf::MeshoptMode>(data[0] % 3);
  view.filter = static_cast<gltf::MeshoptFilter>(data[0] / 3 % 4);
  view.stride = data[1];
  view.count = data[2] + 256u * data[3];
  if (view.count == 0 || gltf::broken_rule(view) != nullptr) return 0;
  const auto compressed = std::as_bytes(std::span(data, size).subspan(4));
  const auto decoded = decode_meshopt(view, compressed, "here", "");
  if (!decoded) {
    fuzz::require(decoded.error().code == "GLTF_COMPRESSION_INVALID", "errors have a code");
    return 0;
  }
  // Every byte that was promised is there and has a value: the sanitizers look on.
  unsigned sum = 0;
  for (std::uint64_t i = 0; i < view.decoded_bytes(); ++i) {
    sum += std::to_integer<unsigned>((*decoded)[i]);
  }
  fuzz::require(sum <= 255 * view.decoded_bytes(), "bytes are bytes");
  return 0;
}
