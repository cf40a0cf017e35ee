#include "core/import/gltf/view_store.h"

#include "core/import/codec/meshopt_view.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

std::string place_of(std::size_t view) { return "bufferView " + std::to_string(view); }
std::string view_pointer(std::size_t view) {
  return "/bufferViews/" + std::to_string(view) + "/extensions/" + kMeshopt;
}

}  // namespace

Result<std::span<const std::byte>> ViewStore::bytes(std::size_t index) {
  const auto meshopt = document_.meshopt.find(index);
  if (meshopt != document_.meshopt.end()) return decoded(index, meshopt->second);
  const auto& view = document_.model.bufferViews[index];
  return part(static_cast<std::size_t>(view.buffer), view.byteOffset, view.byteLength,
              "bufferView " + std::to_string(index), "/bufferViews/" + std::to_string(index));
}

Result<std::span<const std::byte>> ViewStore::compressed(std::size_t index) {
  auto found = bytes(index);
  if (found && is_mapped(index)) {
    compressed_bytes_ += found->size();
    will_need(*found);
  }
  return found;
}

bool ViewStore::is_mapped(std::size_t index) const {
  const auto& view = document_.model.bufferViews[index];
  return document_.meshopt.count(index) == 0 &&
         buffers_.is_mapped(static_cast<std::size_t>(view.buffer));
}

bool ViewStore::is_at_hand(std::size_t index) const {
  const auto meshopt = document_.meshopt.find(index);
  return buffers_.is_at_hand(
      meshopt != document_.meshopt.end()
          ? meshopt->second.buffer
          : static_cast<std::size_t>(document_.model.bufferViews[index].buffer));
}

Result<std::span<const std::byte>> ViewStore::part(std::size_t buffer, std::uint64_t offset,
                                                   std::uint64_t length, const std::string& place,
                                                   const std::string& pointer) {
  auto bytes = buffers_.bytes(buffer);
  if (!bytes) return bytes.error();
  // The sum cannot overflow: the checker bounds every number by 2^53.
  if (offset + length > bytes->size()) {
    return invalid("GLTF_ACCESSOR_OUT_OF_BOUNDS",
                   place + " reaches to " + std::to_string(offset + length) + " bytes, buffer " +
                       std::to_string(buffer) + " has " + std::to_string(bytes->size()),
                   pointer);
  }
  return bytes->subspan(offset, length);
}

Result<std::span<const std::byte>> ViewStore::to_decode(std::size_t index) {
  const MeshoptView& view = document_.meshopt.at(index);
  return part(view.buffer, view.offset, view.length, place_of(index), view_pointer(index));
}

Result<std::span<const std::byte>> ViewStore::decoded(std::size_t index, const MeshoptView& view) {
  if (const auto found = decoded_.find(index); found != decoded_.end()) {
    return std::span<const std::byte>(found->second.get(), view.decoded_bytes());
  }
  auto compressed = to_decode(index);
  if (!compressed) return compressed.error();
  if (Status status = budget_.spend_bytes(view.decoded_bytes()); !status) return status.error();
  if (buffers_.is_mapped(view.buffer)) will_need(*compressed);
  auto bytes = decode_meshopt(view, *compressed, place_of(index), view_pointer(index));
  if (!bytes) return bytes.error();
  if (buffers_.is_mapped(view.buffer)) compressed_bytes_ += view.length;
  const std::byte* const begin = decoded_.emplace(index, *std::move(bytes)).first->second.get();
  return std::span<const std::byte>(begin, view.decoded_bytes());
}

}  // namespace sightline::gltf
