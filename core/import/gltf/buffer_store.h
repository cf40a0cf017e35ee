#pragma once
/// The bytes behind a document's buffers, found when they are first needed and held until the end
/// of the import.

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/import/gltf/gltf_document.h"
#include "core/import/input/mapped_file.h"

namespace sightline::gltf {

class BufferStore {
 public:
  /// binary  the BIN chunk, when there is one; must outlive the store
  /// file    the scene's own file; nothing when it came from memory
  /// neighbour  where the files beside it are then, if anywhere
  BufferStore(const std::vector<BufferEntry>& entries,
              std::optional<std::span<const std::byte>> binary,
              std::optional<std::filesystem::path> file, const ImportLimits& limits,
              NeighbourFinder neighbour = {});

  /// Exactly byte_length bytes. Precondition: index is in range.
  /// Errors: GLTF_URI_REFUSED, GLTF_BUFFER_INVALID, GLTF_FILE_UNREADABLE, GLTF_LIMIT_FILE_BYTES,
  /// GLTF_EXTENSION_UNSUPPORTED (a buffer that only EXT_meshopt_compression could fill).
  Result<std::span<const std::byte>> bytes(std::size_t index);

  /// The bytes of a data URI, or of a file beside the scene's: an image. Errors: as above.
  Result<std::span<const std::byte>> neighbour(const std::string& uri);

  /// Whether its bytes can be had without opening or decoding what nobody has needed so far.
  bool is_at_hand(std::size_t index) const {
    return found_[index].has_value() || !entries_[index].has_uri;
  }
  /// Whether reading this buffer reads the file, rather than text that was decoded before.
  bool is_mapped(std::size_t index) const { return !is_data_uri_[index]; }
  /// Sizes of the external files that were opened.
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
