#include "core/import/gltf/buffer_store.h"

#include <algorithm>

#include "core/import/input/refusal.h"
#include "core/import/input/uri.h"

namespace sightline::gltf {

namespace {

/// Whether `inner`, both free of symbolic links, lies below `folder`.
bool lies_below(const std::filesystem::path& inner, const std::filesystem::path& folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end());
  return end == folder.end() && rest != inner.end();
}

}  // namespace

BufferStore::BufferStore(const std::vector<BufferEntry>& entries,
                         std::optional<std::span<const std::byte>> binary,
                         std::optional<std::filesystem::path> file, const ImportLimits& limits,
                         NeighbourFinder neighbour)
    : entries_(entries),
      binary_(binary),
      file_(std::move(file)),
      limits_(limits),
      neighbour_(std::move(neighbour)),
      found_(entries.size()),
      is_data_uri_(entries.size()) {
  for (std::size_t i = 0; i < entries.size(); ++i) is_data_uri_[i] = is_data_uri(entries[i].uri);
}

Result<std::span<const std::byte>> BufferStore::bytes(std::size_t index) {
  if (found_[index].has_value()) return *found_[index];
  const std::uint64_t needed = entries_[index].byte_length;
  const std::string place = "/buffers/" + std::to_string(index);
  auto found = find(index);
  if (!found) {
    Error error = found.error();
    error.message = "buffer " + std::to_string(index) + ": " + error.message;
    error.pointer = place;
    return error;
  }
  if (found->size() < needed) {
    return invalid("GLTF_BUFFER_INVALID",
                   "buffer " + std::to_string(index) + ": byteLength is " + std::to_string(needed) +
                       ", there are " + std::to_string(found->size()) + " bytes",
                   place);
  }
  found_[index] = found->first(needed);
  return *found_[index];
}

Result<std::span<const std::byte>> BufferStore::find(std::size_t index) {
  const BufferEntry& entry = entries_[index];
  if (entry.has_uri) return neighbour(entry.uri);
  if (entry.fallback_only) {
    return Error{ErrorKind::kUnsupported, "GLTF_EXTENSION_UNSUPPORTED",
                 std::string("its bytes must be decoded by ") + kMeshopt, ""};
  }
  // [glTF2] 4.4.3.3: the BIN chunk is the first buffer, and only when that has no uri.
  if (index == 0 && binary_.has_value()) return *binary_;
  return invalid("GLTF_BUFFER_INVALID", "it has no uri and is not a GLB file's BIN chunk");
}

Result<std::span<const std::byte>> BufferStore::neighbour(const std::string& uri) {
  if (!is_data_uri(uri)) return open_external(uri);
  auto decoded = decode_data_uri(uri);
  if (!decoded) return decoded.error();
  decoded_.push_back(std::make_unique<std::vector<std::byte>>(*std::move(decoded)));
  return std::span<const std::byte>(*decoded_.back());
}

Result<std::span<const std::byte>> BufferStore::open_external(const std::string& uri) {
  auto relative = relative_path(uri);
  if (!relative) return relative.error();
  const std::string name = "\"" + shortened(uri) + "\"";
  if (!file_.has_value() && neighbour_) {
    auto found = neighbour_(relative->string());
    if (found) external_bytes_ += found->size();
    return found;
  }
  if (!file_.has_value()) {
    return invalid("GLTF_URI_REFUSED",
                   name +
                       " is a separate file, which cannot be reached from here: "
                       "send a .glb or embed the buffers");
  }
  // Every symbolic link is resolved before the folder is compared, and the resolved path is opened.
  std::error_code failure;
  const auto folder =
      std::filesystem::canonical(std::filesystem::absolute(*file_, failure).parent_path(), failure);
  const auto resolved = failure ? folder : std::filesystem::canonical(folder / *relative, failure);
  if (failure) {
    return Error{ErrorKind::kNotFound, "GLTF_FILE_UNREADABLE", name + ": no such file", ""};
  }
  if (!lies_below(resolved, folder)) {
    return invalid("GLTF_URI_REFUSED", name + " leads out of the scene's folder");
  }
  if (std::filesystem::equivalent(resolved, *file_, failure)) {
    return invalid("GLTF_URI_REFUSED", name + " is the scene file itself");
  }
  auto mapped = MappedFile::open(resolved, limits_.file_bytes, name);
  if (!mapped) return mapped.error();
  mapped->read_sparsely();
  files_.push_back(*std::move(mapped));
  external_bytes_ += files_.back().bytes().size();
  return files_.back().bytes();
}

}  // namespace sightline::gltf
