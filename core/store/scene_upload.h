#pragma once
/// The bytes of a scene while they arrive: into a temporary file where there is a data folder, else
/// into memory; hashed on the way.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/store/scene_folder.h"
#include "core/store/sha256.h"

namespace sightline {

/// Bytes that all uploads in memory may take in total; a single one may take more. May be used from
/// many threads.
class UploadMemory {
 public:
  explicit UploadMemory(std::uint64_t bytes) : limit_(bytes) {}
  /// `own`: bytes that the caller already has. False where it does not fit now.
  bool take(std::uint64_t bytes, std::uint64_t own);
  void give(std::uint64_t bytes) { taken_ -= bytes; }

 private:
  const std::uint64_t limit_;
  std::atomic<std::uint64_t> taken_{0};
};

class SceneUpload {
 public:
  /// In memory.
  explicit SceneUpload(std::shared_ptr<UploadMemory> shared) : shared_(std::move(shared)) {}
  explicit SceneUpload(TemporaryFile file) : file_(std::move(file)) {}

  SceneUpload(SceneUpload&&) noexcept = default;
  ~SceneUpload() { forget_memory(); }

  /// Errors: those of io_error, MEMORY_BUSY; the upload is then unusable.
  Status append(std::span<const std::byte> piece);
  std::uint64_t size() const { return size_; }

  /// Ends the upload; call once. 64 hexadecimal digits.
  std::string finish_hash() { return hash_.finish(); }
  /// Empty for an upload in memory.
  std::optional<TemporaryFile>& file() { return file_; }
  std::span<const std::byte> memory() const { return memory_; }
  void forget_memory();

 private:
  Status make_room(std::size_t bytes);

  std::optional<TemporaryFile> file_;
  std::shared_ptr<UploadMemory> shared_;  ///< null where there is a file
  std::vector<std::byte> memory_;
  std::uint64_t size_ = 0;
  Sha256 hash_;
};

/// Into a temporary file of the folder; into `memory` where it is null. Errors: those of io_error.
Result<SceneUpload> begin_upload(SceneFolder* folder, std::shared_ptr<UploadMemory> memory);

/// MEMORY_FULL
Error memory_full();

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
