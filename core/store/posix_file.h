#pragma once
/// The few system calls that durable files need, with their errors as Error.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/column.h"
#include "core/base/result.h"

namespace sightline {

/// STORE_FULL (no space, quota, a limit of the process), STORE_BUSY (too many open files),
/// MEMORY_FULL or STORE_IO. `doing` is what failed, without a path: "write a scene". `number` is an
/// errno.
Error io_error(const char* doing, int number);

/// An open file; closed with its last owner.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor() { close(); }

  int number() const { return number_; }
  void close();

 private:
  int number_ = -1;
};

Result<FileDescriptor> open_file(const std::filesystem::path& file, int flags, const char* doing);
Status write_all(const FileDescriptor& file, std::span<const std::byte> bytes, const char* doing);
/// Returns when the bytes are on the disk.
Status sync_file(const FileDescriptor& file, const char* doing);
/// Makes renames and removals in `folder` durable.
Status sync_folder(const std::filesystem::path& folder, const char* doing);
/// Makes a folder and those above it that are missing, durably; there may be one already.
Status make_folder(const std::filesystem::path& folder, const char* doing);
/// Replaces `to` in one step: readers see the old file or the new one.
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing);
/// What lies in a folder, in no order.
Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder,
                                                       const char* doing);
/// A small file as text. Errors: those of io_error; STORE_DAMAGED when it has more than `limit`
/// bytes. Cost: memory for what the file has, not for what it may have.
Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing);

/// A whole file, read-only, as memory that is aligned to 64 bytes. Smaller ones are read: a process
/// has some 65,000 mappings (vm.max_map_count), and there may be as many scenes.
class MappedFile {
 public:
  static constexpr std::size_t kMappedFrom = 1 << 20;

  static Result<MappedFile> map(const FileDescriptor& file, const char* doing);
  MappedFile(MappedFile&& other) noexcept
      : mapped_(std::exchange(other.mapped_, nullptr)),
        read_(std::exchange(other.read_, {})),
        size_(std::exchange(other.size_, 0)) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return {mapped_ ? mapped_ : read_.data(), size_}; }
  /// Else the bytes take memory for as long as this lives.
  bool is_mapped() const { return mapped_ != nullptr; }

 private:
  MappedFile() = default;
  const std::byte* mapped_ = nullptr;
  UnsetColumn<std::byte> read_;
  std::size_t size_ = 0;
};

/// What keeps the bytes of a file that is mapped; null of one that was read: to hold on to all of
/// it for the part that a scene needs would be dearer than a copy of that part.
inline std::shared_ptr<const void> keeper_of(const std::shared_ptr<const MappedFile>& file) {
  return file->is_mapped() ? std::shared_ptr<const void>(file) : nullptr;
}

}  // namespace sightline
