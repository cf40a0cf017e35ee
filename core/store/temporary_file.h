#pragma once
/// TemporaryFile: a file that has no final name until it is complete.

#include <filesystem>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// A file and its path. The destructor closes and removes the file, unless it was released.
class TemporaryFile {
 public:
  TemporaryFile(FileDescriptor file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}
  TemporaryFile(TemporaryFile&& other) noexcept
      : file_(std::move(other.file_)), path_(std::exchange(other.path_, {})) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();

  const FileDescriptor& file() const { return file_; }
  /// Where the file is; empty after release().
  const std::filesystem::path& path() const { return path_; }
  /// Closes the file; it remains until release() or the destructor.
  void close() { file_.close(); }
  /// Lets the file remain: it was renamed.
  void release() { path_.clear(); }

 private:
  FileDescriptor file_;
  std::filesystem::path path_;
};

/// Makes an empty file at `path`, replacing an existing one. Errors: those of io_error.
Result<TemporaryFile> make_temporary(std::filesystem::path path, const char* doing);

/// Writes the text to `temporary` and syncs it, without renaming. Errors: those of io_error.
Status fill_durably(TemporaryFile& temporary, std::string_view text, const char* doing);
/// Writes the text to `temporary`, syncs it, and renames it to `target`, which is replaced. Errors:
/// those of io_error; `target` is then unchanged, or, if only the last sync failed, it is the new
/// file unless the machine crashes.
Status write_durably(TemporaryFile& temporary, std::string_view text,
                     const std::filesystem::path& target, const char* doing);

}  // namespace sightline

// Tests: tests/unit/store/scene_record_test.cpp
