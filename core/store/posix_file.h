#pragma once
/// The few system calls that durable files need, with their errors as Error.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

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
/// The names in a folder, unsorted.
Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder,
                                                       const char* doing);
/// A small file as text. Errors: those of io_error; STORE_DAMAGED when it has more than `limit`
/// bytes. Cost: memory for what the file has, not for what it may have.
Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing);

/// Reads from the byte `offset` on until `bytes` are filled or the file ends; returns how many
/// bytes were read. Errors: those of io_error.
Result<std::size_t> read_at(const FileDescriptor& file, std::uint64_t offset,
                            std::span<std::byte> bytes, const char* doing);

}  // namespace sightline

// Tests: tests/unit/store/durable_test.cpp
