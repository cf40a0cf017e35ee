#pragma once
/// The bytes of a scene while they arrive: into a temporary file where there is a data folder, else
/// into memory; hashed on the way.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/store/scene_folder.h"
#include "core/store/sha256.h"

namespace sightline {

class SceneUpload {
 public:
  /// In memory.
  SceneUpload() = default;
  explicit SceneUpload(TemporaryFile file) : file_(std::move(file)) {}

  /// Errors: those of io_error; the upload is then unusable.
  Status append(std::span<const std::byte> piece);
  std::uint64_t size() const { return size_; }

  /// Ends the upload; call once. 64 hexadecimal digits.
  std::string finish_hash() { return hash_.finish(); }
  /// Empty for an upload in memory.
  std::optional<TemporaryFile>& file() { return file_; }
  std::span<const std::byte> memory() const { return memory_; }
  void forget_memory() { memory_ = {}; }

 private:
  std::optional<TemporaryFile> file_;
  std::vector<std::byte> memory_;
  std::uint64_t size_ = 0;
  Sha256 hash_;
};

/// Into a temporary file of the folder; into memory where it is null. Errors: those of io_error.
Result<SceneUpload> begin_upload(SceneFolder* folder);

/// MEMORY_FULL
Error memory_full();

}  // namespace sightline
