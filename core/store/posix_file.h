#pragma once
/// The system calls that durable files need; failures are returned as Error.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// The error of a failed system call: STORE_FULL (no space, quota, or a limit of the process),
/// STORE_BUSY (too many open files), MEMORY_FULL or STORE_IO. `doing` names what failed, without a
/// path: "write a scene". `number` is an errno. The functions below return these errors.
Error io_error(const char* doing, int number);

/// An open file, closed by the destructor; or none, with the number -1.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Takes over an open file; -1: none.
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor() { close(); }

  int number() const { return number_; }
  /// Closes the file if it is open.
  void close();

 private:
  int number_ = -1;
};

/// Opens a file; `flags` are those of open(2). A new file has the mode 0640, less the umask.
Result<FileDescriptor> open_file(const std::filesystem::path& file, int flags, const char* doing);
/// Writes all bytes at the file's position. After an error some of them may be written.
Status write_all(const FileDescriptor& file, std::span<const std::byte> bytes, const char* doing);
/// Waits until the file's bytes are on the disk.
Status sync_file(const FileDescriptor& file, const char* doing);
/// Waits until renames and removals in `folder` are on the disk.
Status sync_folder(const std::filesystem::path& folder, const char* doing);
/// Makes a folder, and missing folders above it, and waits until they are on the disk. It is no
/// error if the folder exists.
Status make_folder(const std::filesystem::path& folder, const char* doing);
/// Renames a file, atomically replacing `to`: readers see the old file or the new one. Not durable
/// before sync_folder.
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing);
/// Returns the names in a folder, unsorted.
Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder,
                                                       const char* doing);
/// Returns the content of a small file as text. Errors: those of io_error; STORE_DAMAGED if it has
/// more than `limit` bytes. Memory is allocated for the bytes that it has, not for `limit`.
Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing);

/// Reads from byte `offset` on until `bytes` is filled or the file ends; returns the number of
/// bytes read. Errors: those of io_error.
Result<std::size_t> read_at(const FileDescriptor& file, std::uint64_t offset,
                            std::span<std::byte> bytes, const char* doing);

}  // namespace sightline

// Tests: tests/unit/store/durable_test.cpp
