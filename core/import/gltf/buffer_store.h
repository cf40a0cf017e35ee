#pragma once
/// BufferStore: the bytes of a document's buffers. A buffer is opened or decoded when it is first
/// needed, and stays in memory until the end of the import.

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/mapped_file.h"

namespace sightline::gltf {

/// The buffers of one document. Returned bytes are valid while the store lives. Not thread-safe.
class BufferStore {
 public:
  /// entries, limits  must outlive the store
  /// binary     the BIN chunk if there is one; must outlive the store
  /// file       path of the scene's file; empty if the scene came from memory
  /// neighbour  finds other files for a scene from memory; may be empty
  BufferStore(const std::vector<BufferEntry>& entries,
              std::optional<std::span<const std::byte>> binary,
              std::optional<std::filesystem::path> file, const ImportLimits& limits,
              NeighbourFinder neighbour = {});

  /// Returns the byte_length bytes of a buffer. Precondition: index is in range. Errors:
  /// GLTF_URI_REFUSED, GLTF_BUFFER_INVALID, GLTF_FILE_UNREADABLE, GLTF_LIMIT_FILE_BYTES,
  /// GLTF_EXTENSION_UNSUPPORTED (for a buffer that only EXT_meshopt_compression could fill).
  Result<std::span<const std::byte>> bytes(std::size_t index);

  /// Sets the bytes of a buffer, which must outlive the store. find() is not called for it.
  void provide(std::size_t index, std::span<const std::byte> bytes) { found_[index] = bytes; }

  /// Returns the bytes of a data URI, or of a file beside the scene's file, such as an image. Not
  /// cached: each call opens or decodes again. Errors: those of bytes(), those of the finder.
  Result<std::span<const std::byte>> neighbour(const std::string& uri);

  /// True if bytes(index) opens no file and decodes nothing that was not needed before.
  bool is_at_hand(std::size_t index) const {
    return found_[index].has_value() || !entries_[index].has_uri;
  }
  /// True if the bytes are those of a file; false if they were decoded from a data URI.
  bool is_mapped(std::size_t index) const { return !is_data_uri_[index]; }
  /// Total size of the external files that were opened, in bytes.
  std::uint64_t external_bytes() const { return external_bytes_; }

 private:
  Result<std::span<const std::byte>> find(std::size_t index);
  Result<std::span<const std::byte>> open_external(const std::string& uri);

  const std::vector<BufferEntry>& entries_;
  std::optional<std::span<const std::byte>> binary_;
  std::optional<std::filesystem::path> file_;
  const ImportLimits& limits_;
  NeighbourFinder neighbour_;
  std::vector<std::optional<std::span<const std::byte>>> found_;
  std::vector<bool> is_data_uri_;
  std::vector<MappedFile> files_;
  std::vector<std::unique_ptr<std::vector<std::byte>>> decoded_;
  std::uint64_t external_bytes_ = 0;
};

}  // namespace sightline::gltf
