#pragma once
/// FileBytes: a whole file in the memory of this process.
///
/// A stored file is read, not mapped: if the disk cannot deliver a page of a mapping, or the file
/// was truncated, the access is a signal that ends the process. A failing read is an error of one
/// scene. docs/decisions/0021-stored-files-are-read.md has measurements.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "core/base/column.h"
#include "core/base/overflow_memory.h"
#include "core/base/pages.h"
#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// The memory for a file of so many bytes that exceeds the memory budget; null: ordinary memory. An
/// empty function: ordinary memory for all.
using OverflowFor = std::function<std::shared_ptr<OverflowMemory>(std::uint64_t bytes)>;

/// The bytes of a file that was read; the destructor frees them. If a scene will refer to the
/// bytes: claim() each part that it needs, then drop_unclaimed().
class FileBytes {
 public:
  /// Files of at least so many bytes are read by all threads into pages of the system, and scenes
  /// refer to these pages. From a smaller file a scene copies what it needs.
  static constexpr std::size_t kSharedFrom = 1 << 20;

  /// Reads a file from its beginning. `doing` names the purpose in errors. Errors: those of
  /// io_error; STORE_IO also if a file of kSharedFrom bytes or more becomes shorter meanwhile.
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing);
  /// Reads a file, and sets `fingerprint` to the hash_in_pieces of its bytes. Computing it while
  /// the bytes are in the processor's cache costs less than a second pass. Errors also: OVERFLOW_FULL.
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing,
                                std::uint64_t& fingerprint, const OverflowFor& overflow_for = {});
  /// Takes memory of `size` bytes, which `fill` fills. `doing` names the purpose in errors. Errors:
  /// MEMORY_FULL, OVERFLOW_FULL, those of `fill`.
  static Result<FileBytes> make(std::size_t size, const char* doing,
                                const std::function<Status(std::span<std::byte>)>& fill,
                                const OverflowFor& overflow_for = {});
  /// Takes over the first `size` bytes of `pages`, which hold a file, without a copy. A small file
  /// is copied, and so is one that `overflow_for` places. Errors: those of make.
  static Result<FileBytes> adopt(OwnedPages pages, std::size_t size, const char* doing,
                                 const OverflowFor& overflow_for = {});
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&&) = delete;
  ~FileBytes();

  /// The content of the file, aligned to 64 bytes.
  std::span<const std::byte> bytes() const {
    return {pages_ != nullptr ? pages_ : small_.data(), size_};
  }
  /// True if scenes may refer to the bytes (kSharedFrom).
  bool is_shared() const { return pages_ != nullptr; }

  /// Marks `part`, a part of bytes(), as needed after the load. Thread-safe.
  void claim(std::span<const std::byte> part) const;
  /// Returns pages without a claimed part to the system; they read as zeros afterwards.
  /// Preconditions: only claimed parts are read from now on, and nothing more is claimed.
  void drop_unclaimed() const;

 private:
  using Range = std::pair<std::size_t, std::size_t>;
  FileBytes() = default;
  static Result<FileBytes> read(const FileDescriptor& file, const char* doing,
                                std::uint64_t* fingerprint, const OverflowFor& overflow_for);

  std::byte* pages_ = nullptr;
  std::shared_ptr<OverflowMemory> overflow_;  ///< null: pages_ are of take_pages
  std::shared_ptr<std::byte> piece_;          ///< owner of pages_ in overflow_
  UnsetColumn<std::byte> small_;
  std::size_t size_ = 0;
  mutable std::mutex mutex_;
  mutable std::vector<Range> claims_;
};

/// The owner of the bytes for scenes that refer to them; null if is_shared() is false. `file` is
/// not null.
inline std::shared_ptr<const void> owner_of_bytes(const std::shared_ptr<const FileBytes>& file) {
  return file->is_shared() ? std::shared_ptr<const void>(file) : nullptr;
}

}  // namespace sightline
