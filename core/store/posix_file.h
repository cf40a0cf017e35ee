#pragma once
/// The few system calls that durable files need, with their errors as Error.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace sightline {

/// STORE_FULL (no space, quota) or STORE_IO. `doing` is what failed, without a path: "write a
/// scene". `number` is an errno.
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
/// Replaces `to` in one step: readers see the old file or the new one.
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing);
/// A small file as text. Errors: STORE_IO, also when it has more than `limit` bytes.
Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing);

/// A whole file, read-only, as memory.
class MappedFile {
 public:
  static Result<MappedFile> map(const FileDescriptor& file, const char* doing);
  MappedFile(MappedFile&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  MappedFile() = default;
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace sightline
