#include "server/sources/scene_root.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

namespace sightline {
namespace {

constexpr std::size_t kLongestPath = 4096;
constexpr std::size_t kPiece = 1 << 20;
/// A path that others move about at this moment is resolved again, so many times.
constexpr int kTries = 16;

/// -1 and errno, as open. The C library has no name for this call.
int open_beneath(int folder, const std::string& path, int flags) {
  open_how how{};
  how.flags = static_cast<decltype(how.flags)>(flags | O_CLOEXEC);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  long number = -1;
  for (int i = 0; i < kTries; ++i) {
    number = ::syscall(SYS_openat2, folder, path.c_str(), &how, sizeof how);
    if (number >= 0 || (errno != EAGAIN && errno != EINTR)) break;
  }
  return static_cast<int>(number);
}

Error refused(const char* why) {
  return {ErrorKind::kInvalid, "PATH_REFUSED", std::string("the path ") + why, ""};
}

Error not_found() {
  return {ErrorKind::kInvalid, "SOURCE_NOT_FOUND",
          "there is no file at this path below the server's scene root, or it may not be read", ""};
}

Status check_path(const std::string& path) {
  if (path.empty()) return refused("is empty");
  if (path.size() > kLongestPath) return refused("is longer than 4096 bytes");
  if (path.front() == '/') return refused("is absolute; a path is relative to the scene root");
  const bool has_control = std::any_of(path.begin(), path.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (has_control) return refused("has a control character");
  return success();
}

Error error_of_open(int number) {
  switch (number) {
    case EXDEV:
    case ELOOP:
      return refused("leads out of the scene root");
    case ENAMETOOLONG:
    case ENOENT:
    case ENOTDIR:
    case EACCES:
    case EPERM:
    case ENXIO:
      return not_found();
  }
  return io_error("read the source", number);  // says nothing about the file
}

Result<SceneRoot::File> open_regular(int folder, const std::string& path, std::uint64_t limit) {
  if (Status status = check_path(path); !status) return std::move(status).error();
  // O_NONBLOCK: opening a pipe must not wait.
  const int number = open_beneath(folder, path, O_RDONLY | O_NONBLOCK | O_NOCTTY);
  if (number < 0) return error_of_open(errno);
  SceneRoot::File opened{FileDescriptor(number), 0};
  struct stat status {};
  if (::fstat(number, &status) != 0) return error_of_open(errno);
  if (!S_ISREG(status.st_mode)) return not_found();
  opened.bytes = static_cast<std::uint64_t>(status.st_size);
  if (opened.bytes > limit) return source_too_large(limit);
  return opened;
}

}  // namespace

Error source_too_large(std::uint64_t limit) {
  return {ErrorKind::kTooLarge, "SOURCE_TOO_LARGE",
          "the source may have " + std::to_string(limit) + " bytes, with all of its files", ""};
}

Result<SceneRoot> SceneRoot::open(const std::filesystem::path& folder) {
  const Error invalid{ErrorKind::kInvalid, "SCENE_ROOT_INVALID",
                      "the scene root is no folder that can be opened", ""};
  FileDescriptor opened(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (opened.number() < 0) return invalid;
  const FileDescriptor probe(open_beneath(opened.number(), ".", O_PATH | O_DIRECTORY));
  if (probe.number() < 0) {
    return Error{ErrorKind::kInvalid, "SCENE_ROOT_INVALID",
                 errno == ENOSYS
                     ? "a scene root needs a kernel that has openat2 (Linux 5.6)"
                     : "cannot open the scene root: " + std::generic_category().message(errno),
                 ""};
  }
  return SceneRoot(std::move(opened));
}

Result<SceneRoot::File> SceneRoot::open_file(const std::string& path, std::uint64_t limit) const {
  return open_regular(folder_.number(), path, limit);
}

Result<SceneRoot::File> SceneRoot::open_neighbour(const std::string& path,
                                                  const std::string& neighbour,
                                                  std::uint64_t limit) const {
  const std::size_t slash = path.rfind('/');
  const std::string parent = slash == std::string::npos ? "." : path.substr(0, slash);
  const FileDescriptor folder(open_beneath(folder_.number(), parent, O_PATH | O_DIRECTORY));
  if (folder.number() < 0) return error_of_open(errno);
  return open_regular(folder.number(), neighbour, limit);
}

Status read_file(const SceneRoot::File& file, std::uint64_t limit, const ByteSink& sink) {
  std::vector<std::byte> piece(kPiece);
  std::uint64_t size = 0;
  for (;;) {
    const ssize_t got = ::read(file.file.number(), piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error_of_open(errno);
    if (got == 0) return success();
    size += static_cast<std::uint64_t>(got);
    if (size > limit) return source_too_large(limit);
    Status status = sink(std::span(piece).first(static_cast<std::size_t>(got)));
    if (!status) return status;
  }
}

}  // namespace sightline
