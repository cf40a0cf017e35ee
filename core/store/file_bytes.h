#pragma once
/// A whole file in memory of this process.
///
/// A stored file is read, never mapped: a page of a mapping that the disk cannot deliver, or that a
/// cut file no longer has, is a signal that ends the process. A failing read is an error of one
/// scene. docs/decisions/0021-stored-files-are-read.md has the measurements.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

class FileBytes {
 public:
  /// Files from this size on are read by all threads into pages of the system, and scenes share
  /// them. Of smaller files a scene copies what it needs.
  static constexpr std::size_t kSharedFrom = 1 << 20;

  /// Errors: those of io_error; STORE_IO also where the file becomes shorter while it is read.
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing);
  /// As read, and sets `fingerprint` to the hash_in_pieces of the bytes: computed while they are in
  /// the processor's cache, it costs less than another pass.
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing,
                                std::uint64_t& fingerprint);
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&&) = delete;
  ~FileBytes();

  /// Aligned to 64 bytes.
  std::span<const std::byte> bytes() const {
    return {pages_ != nullptr ? pages_ : small_.data(), size_};
  }
  bool is_shared() const { return pages_ != nullptr; }

  /// Marks a part of bytes() as needed beyond the load. May be called from several threads.
  void claim(std::span<const std::byte> part) const;
  /// Returns the pages without any claim to the system; they read as zeros then. Precondition: only
  /// claimed parts are read from here on, and nothing is claimed.
  void drop_unclaimed() const;

 private:
  using Range = std::pair<std::size_t, std::size_t>;
  FileBytes() = default;
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing,
                                std::uint64_t* fingerprint);

  std::byte* pages_ = nullptr;
  UnsetColumn<std::byte> small_;
  std::size_t size_ = 0;
  mutable std::mutex mutex_;
  mutable std::vector<Range> claims_;
};

/// Owns the bytes of a file that scenes share; null for a small file.
inline std::shared_ptr<const void> owner_of_bytes(const std::shared_ptr<const FileBytes>& file) {
  return file->is_shared() ? std::shared_ptr<const void>(file) : nullptr;
}

}  // namespace sightline
