#include "core/import/codec/meshopt_view.h"

#include <meshoptimizer.h>

#include <algorithm>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

int decode(const MeshoptView& view, const unsigned char* from, std::size_t size, std::byte* to) {
  switch (view.mode) {
    case MeshoptMode::kAttributes:
      return meshopt_decodeVertexBuffer(to, view.count, view.stride, from, size);
    case MeshoptMode::kTriangles:
      return meshopt_decodeIndexBuffer(to, view.count, view.stride, from, size);
    default:
      return meshopt_decodeIndexSequence(to, view.count, view.stride, from, size);
  }
}

void unfilter(const MeshoptView& view, std::byte* data) {
  switch (view.filter) {
    case MeshoptFilter::kOctahedral:
      return meshopt_decodeFilterOct(data, view.count, view.stride);
    case MeshoptFilter::kQuaternion:
      return meshopt_decodeFilterQuat(data, view.count, view.stride);
    case MeshoptFilter::kExponential:
      return meshopt_decodeFilterExp(data, view.count, view.stride);
    default:
      return;
  }
}

}  // namespace

const char* broken_rule(const MeshoptView& view) {
  if (view.mode != MeshoptMode::kAttributes) {
    if (view.stride != 2 && view.stride != 4) return "needs a byteStride of 2 or 4 for indices";
    if (view.filter != MeshoptFilter::kNone) return "must not filter indices";
    if (view.mode == MeshoptMode::kTriangles && view.count % 3 != 0) {
      return "needs a count that is a multiple of 3 for triangles";
    }
    return nullptr;
  }
  if (view.stride == 0 || view.stride > 256 || view.stride % 4 != 0) {
    return "needs a byteStride that is a multiple of 4 from 4 to 256 for attributes";
  }
  if (view.filter == MeshoptFilter::kOctahedral && view.stride != 4 && view.stride != 8) {
    return "needs a byteStride of 4 or 8 for the filter OCTAHEDRAL";
  }
  if (view.filter == MeshoptFilter::kQuaternion && view.stride != 8) {
    return "needs a byteStride of 8 for the filter QUATERNION";
  }
  return nullptr;
}

std::uint64_t fewest_bytes(const MeshoptView& view) {
  switch (view.mode) {
    case MeshoptMode::kAttributes:
      // A version byte; two header bits for every 16 values of each of an element's bytes, padded
      // to whole bytes; a tail that holds one element and has 32 bytes at least.
      return 1 + (view.count + 63) / 64 * view.stride + std::max<std::uint64_t>(32, view.stride);
    case MeshoptMode::kTriangles:
      return 1 + view.count / 3 + 16;
    default:
      return 1 + view.count + 4;
  }
}

Result<std::unique_ptr<std::byte[]>> decode_meshopt(const MeshoptView& view,
                                                    std::span<const std::byte> compressed,
                                                    const std::string& place,
                                                    const std::string& pointer) {
  const auto broken = [&](const std::string& what) {
    return invalid("GLTF_COMPRESSION_INVALID", place + ": " + kMeshopt + ": " + what, pointer);
  };
  const std::string elements =
      std::to_string(view.count) + " elements of " + std::to_string(view.stride) + " bytes";
  if (compressed.size() < fewest_bytes(view)) {
    return broken(elements + " need at least " + std::to_string(fewest_bytes(view)) +
                  " compressed bytes, there are " + std::to_string(compressed.size()));
  }
  // Not initialised: every byte is written, or what was written is thrown away.
  std::unique_ptr<std::byte[]> decoded(new std::byte[view.decoded_bytes()]);
  const auto* from = reinterpret_cast<const unsigned char*>(compressed.data());
  const int verdict = decode(view, from, compressed.size(), decoded.get());
  if (verdict == -1) return broken("the compressed bytes are of another kind or a later version");
  if (verdict != 0) {
    return broken("the " + std::to_string(compressed.size()) + " compressed bytes do not hold " +
                  elements);
  }
  unfilter(view, decoded.get());
  return decoded;
}

}  // namespace sightline::gltf
