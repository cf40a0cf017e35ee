#pragma once
/// SceneUpload: receives the bytes of a scene and hashes them. They are stored in a temporary file
/// if there is a data folder, else in memory.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/base/pages.h"
#include "core/base/result.h"
#include "core/store/file_bytes.h"
#include "core/store/scene_folder.h"
#include "core/store/sha256.h"

namespace sightline {

/// Limits the bytes of all loads in memory. A single load may exceed the limit if it is the only
/// one. Thread-safe.
class UploadMemory {
 public:
  explicit UploadMemory(std::uint64_t bytes) : limit_(bytes) {}
  /// Takes `bytes` more for a load that has taken `own` bytes already. Returns false, and takes
  /// nothing, if the limit does not allow it now.
  bool take(std::uint64_t bytes, std::uint64_t own);
  /// Returns bytes of a load that were freed.
  void give(std::uint64_t bytes) { taken_ -= bytes; }

 private:
  const std::uint64_t limit_;
  std::atomic<std::uint64_t> taken_{0};
};

/// What one load has taken of UploadMemory, for all of its files. Not thread-safe.
class LoadMemory {
 public:
  /// `all` is not null.
  explicit LoadMemory(std::shared_ptr<UploadMemory> all) : all_(std::move(all)) {}
  /// Takes bytes; false, and nothing is taken, if the limit does not allow it now.
  bool take(std::uint64_t bytes) {
    if (!all_->take(bytes, taken_)) return false;
    taken_ += bytes;
    return true;
  }
  /// Returns bytes that were taken.
  void give(std::uint64_t bytes) {
    all_->give(bytes);
    taken_ -= bytes;
  }

 private:
  std::shared_ptr<UploadMemory> all_;
  std::uint64_t taken_ = 0;
};

/// The bytes of one upload: append(), then finish_hash(). The destructor frees them. Not
/// thread-safe.
class SceneUpload {
 public:
  /// An upload into memory; `shared` is not null.
  explicit SceneUpload(std::shared_ptr<LoadMemory> shared) : shared_(std::move(shared)) {}
  /// An upload into a file.
  explicit SceneUpload(TemporaryFile file) : file_(std::move(file)) {}

  SceneUpload(SceneUpload&& other) noexcept
      : file_(std::move(other.file_)),
        shared_(std::move(other.shared_)),
        memory_(std::move(other.memory_)),
        taken_(std::exchange(other.taken_, 0)),
        size_(other.size_),
        hash_(std::move(other.hash_)) {}
  ~SceneUpload() { forget_memory(); }

  /// Appends bytes. Errors, after which the upload is unusable: those of io_error for a file,
  /// MEMORY_BUSY and MEMORY_FULL for memory.
  Status append(std::span<const std::byte> piece);
  std::uint64_t size() const { return size_; }

  /// Ends the upload and returns the SHA-256 as 64 hexadecimal digits; empty if it could not be
  /// computed (Sha256::finish). Must be called once.
  std::string finish_hash() { return hash_.finish(); }
  /// What counts the memory of the load; null for an upload into a file.
  const std::shared_ptr<LoadMemory>& load_memory() const { return shared_; }
  /// The temporary file; empty for an upload into memory.
  std::optional<TemporaryFile>& file() { return file_; }
  /// The bytes of an upload into memory, valid until take_memory() or forget_memory(); empty for a
  /// file.
  std::span<const std::byte> memory() const {
    return {memory_.get(), memory_ == nullptr ? 0 : static_cast<std::size_t>(size_)};
  }
  /// Moves the bytes in memory to the caller (FileBytes::adopt). They count against the limit of
  /// all uploads until forget_memory(). Errors: those of FileBytes::make.
  Result<FileBytes> take_memory(const OverflowFor& overflow_for);
  /// Frees the bytes in memory, unless they were taken.
  void forget_memory();

 private:
  Status make_room(std::size_t bytes);

  std::optional<TemporaryFile> file_;
  std::shared_ptr<LoadMemory> shared_;  ///< of all files of the load; null if there is a file
  OwnedPages memory_;
  std::uint64_t taken_ = 0;  ///< bytes taken from shared_
  std::uint64_t size_ = 0;
  BackgroundSha256 hash_;
};

/// Begins an upload into a temporary file of `folder`, or into `memory` if `folder` is null. One of
/// both is not null.
/// Errors: those of io_error.
Result<SceneUpload> begin_upload(SceneFolder* folder, std::shared_ptr<LoadMemory> memory);

/// The error MEMORY_FULL: there is no memory left for the scene.
Error memory_full();

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
