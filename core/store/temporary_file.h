#pragma once
/// A file without a final name until it is complete.

#include <filesystem>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// Gone with this object unless it was released.
class TemporaryFile {
 public:
  TemporaryFile(FileDescriptor file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}
  TemporaryFile(TemporaryFile&& other) noexcept
      : file_(std::move(other.file_)), path_(std::exchange(other.path_, {})) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();

  const FileDescriptor& file() const { return file_; }
  const std::filesystem::path& path() const { return path_; }
  /// The name stays until release() or the end of this object.
  void close() { file_.close(); }
  /// It has another name now and stays.
  void release() { path_.clear(); }

 private:
  FileDescriptor file_;
  std::filesystem::path path_;
};

/// A file of this name, empty, in place of whatever file had it. Errors: those of io_error.
Result<TemporaryFile> make_temporary(std::filesystem::path path, const char* doing);

/// Fills `temporary` with the text, durably, under the name that it has. Errors: those of io_error.
Status fill_durably(TemporaryFile& temporary, std::string_view text, const char* doing);
/// Writes durably and renames to `target`, replacing what had that name. Errors: those of io_error.
/// `target` is then unchanged or, where only the last step failed, the new file until a crash.
Status write_durably(TemporaryFile& temporary, std::string_view text,
                     const std::filesystem::path& target, const char* doing);

}  // namespace sightline

// Tests: tests/unit/store/scene_record_test.cpp
