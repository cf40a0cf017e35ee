#pragma once
/// SceneRoot: the folder below which clients may name files.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// Receives bytes in pieces, each valid during the call. An error ends the transfer.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

/// Opens files below a folder, and nothing outside of it: the kernel resolves each path beneath it
/// (openat2, RESOLVE_BENEATH). So neither ".." nor a symbolic link leads outside, even if it is
/// created at the same moment. Links that stay inside are followed. Its const functions are
/// thread-safe.
class SceneRoot {
 public:
  /// Opens the folder. Errors: SCENE_ROOT_INVALID (not a folder, or a kernel before Linux 5.6).
  static Result<SceneRoot> open(const std::filesystem::path& folder);

  /// An open file and its size.
  struct File {
    FileDescriptor file;
    std::uint64_t bytes = 0;
  };
  /// Opens a regular file of at most `limit` bytes. Errors, which name no path of this machine:
  /// PATH_REFUSED (empty, longer than 4096 bytes, absolute, leads outside, or has a control
  /// character), SOURCE_NOT_FOUND (absent, not readable, or no regular file), SOURCE_TOO_LARGE. A
  /// failure of the disk is an io_error.
  Result<File> open_file(const std::string& path, std::uint64_t limit) const;
  /// Opens `neighbour`, a path relative to the folder of the file at `path`; it must be in that
  /// folder or below. Errors: those of open_file.
  Result<File> open_neighbour(const std::string& path, const std::string& neighbour,
                              std::uint64_t limit) const;

 private:
  explicit SceneRoot(FileDescriptor folder) : folder_(std::move(folder)) {}
  FileDescriptor folder_;
};

/// Passes the bytes of a file to `sink`, from its present position to its end. The file may shrink
/// or grow meanwhile. `limit` is the most bytes. Errors:
/// SOURCE_TOO_LARGE, SOURCE_NOT_FOUND (it cannot be read), those of the sink.
Status read_file(const SceneRoot::File& file, std::uint64_t limit, const ByteSink& sink);

/// The error SOURCE_TOO_LARGE: a source with all of its files may have `limit` bytes.
Error source_too_large(std::uint64_t limit);

}  // namespace sightline
