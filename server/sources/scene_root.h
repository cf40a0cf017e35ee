#pragma once
/// The folder from which clients may name files.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/store/posix_file.h"

namespace sightline {

/// Takes bytes in pieces.
using ByteSink = std::function<Status(std::span<const std::byte>)>;

/// Never opens anything outside of the folder: the kernel resolves each path beneath it (openat2,
/// RESOLVE_BENEATH). So neither ".." nor a symbolic link leads out, even if it is created at the
/// same moment. Links that stay inside are followed.
class SceneRoot {
 public:
  /// Errors: SCENE_ROOT_INVALID (no folder, or a kernel before Linux 5.6).
  static Result<SceneRoot> open(const std::filesystem::path& folder);

  struct File {
    FileDescriptor file;
    std::uint64_t bytes = 0;
  };
  /// A regular file. Errors, which name no path of this machine: PATH_REFUSED (absolute, leads out,
  /// or has a control character), SOURCE_NOT_FOUND (no such file, or it may not be read),
  /// SOURCE_TOO_LARGE.
  Result<File> open_file(const std::string& path, std::uint64_t limit) const;
  /// A file beside the file at `path`: in that file's folder or below.
  Result<File> open_neighbour(const std::string& path, const std::string& neighbour,
                              std::uint64_t limit) const;

 private:
  explicit SceneRoot(FileDescriptor folder) : folder_(std::move(folder)) {}
  FileDescriptor folder_;
};

/// Hands the bytes of a file on, as they are now: a file that shrinks or grows meanwhile is no
/// danger. Errors: SOURCE_TOO_LARGE, SOURCE_NOT_FOUND (it cannot be read), those of the sink.
Status read_file(const SceneRoot::File& file, std::uint64_t limit, const ByteSink& sink);

Error source_too_large(std::uint64_t limit);

}  // namespace sightline
