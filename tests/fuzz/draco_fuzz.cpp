// Bytes of KHR_draco_mesh_compression: a mesh in range that agrees with the claim, or an error.
// Input: the claim (triangles and points little-endian, an attribute), three more bytes, then the
// compressed bytes.
// Run:  scripts/stress.sh fuzz --target draco_fuzz

#include <cstdint>
#include <span>

#include "core/import/codec/draco_mesh.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 8) return 0;
  const gltf::DracoClaim claim = {data[0] + 256u * data[1], data[2] + 256u * data[3], {data[4]}};
  ImportLimits limits;
  limits.geometry_bytes = 64u << 20;
  gltf::Budget budget(limits);
  const auto compressed = std::as_bytes(std::span(data, size).subspan(8));
  const auto mesh = decode_draco(compressed, claim, budget, "here", "");
  fuzz::require(budget.spend_bytes(limits.geometry_bytes).ok(), "the decoder's memory came back");
  if (!mesh) {
    fuzz::require(!mesh.error().code.empty(), "errors have a code");
    return 0;
  }
  fuzz::require(mesh->points == claim.points && mesh->corners.size() == claim.triangles * 3,
                "a mesh is as large as was claimed");
  for (const std::uint32_t corner : mesh->corners) {
    fuzz::require(corner < mesh->points, "corners are points");
  }
  const gltf::DecodedElements& elements = mesh->attributes.at(data[4]);
  fuzz::require(elements.bytes.size() ==
                    mesh->points * elements.components * gltf::component_bytes(elements.component),
                "an attribute has one element per point");
  return 0;
}
