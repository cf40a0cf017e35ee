#include "core/store/posix_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace sightline {
namespace {

/// Of a small file at once, whatever it says of its size.
constexpr std::size_t kLeastRead = 4096;

}  // namespace

Error io_error(const char* doing, int number) {
  Error error{ErrorKind::kInternal, "STORE_IO",
              std::string("cannot ") + doing + ": " + std::generic_category().message(number), ""};
  switch (number) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      error.kind = ErrorKind::kOutOfSpace;
      error.code = "STORE_FULL";
      break;
    case EMFILE:
    case ENFILE:
      error.kind = ErrorKind::kBusy;
      error.code = "STORE_BUSY";
      break;
    case ENOMEM:
      error.kind = ErrorKind::kOutOfSpace;
      error.code = "MEMORY_FULL";
      break;
  }
  return error;
}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    close();
    number_ = std::exchange(other.number_, -1);
  }
  return *this;
}

void FileDescriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

Result<FileDescriptor> open_file(const std::filesystem::path& file, int flags, const char* doing) {
  const int number = ::open(file.c_str(), flags | O_CLOEXEC, 0640);
  if (number < 0) return io_error(doing, errno);
  return FileDescriptor(number);
}

Status write_all(const FileDescriptor& file, std::span<const std::byte> bytes, const char* doing) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.number(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return io_error(doing, errno);
    }
    if (written == 0) return io_error(doing, ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return success();
}

Status sync_file(const FileDescriptor& file, const char* doing) {
  if (::fsync(file.number()) != 0) return io_error(doing, errno);
  return success();
}

Status sync_folder(const std::filesystem::path& folder, const char* doing) {
  auto opened = open_file(folder, O_RDONLY | O_DIRECTORY, doing);
  if (!opened) return opened.error();
  return sync_file(*opened, doing);
}

Status make_folder(const std::filesystem::path& folder, const char* doing) {
  // From the lowest folder that exists, each with its name in its parent.
  std::vector<std::filesystem::path> missing;
  std::error_code error;
  auto at = std::filesystem::absolute(folder, error);
  if (error) return io_error(doing, error.value());
  if (!at.has_filename()) at = at.parent_path();
  for (; !std::filesystem::is_directory(at, error); at = at.parent_path()) {
    missing.push_back(at);
    if (at == at.parent_path()) break;
  }
  for (; !missing.empty(); missing.pop_back()) {
    if (::mkdir(missing.back().c_str(), 0777) != 0 && errno != EEXIST)
      return io_error(doing, errno);
    if (Status synced = sync_folder(missing.back().parent_path(), doing); !synced) return synced;
  }
  // Something else in its place would fail only at its first use.
  if (!std::filesystem::is_directory(folder, error)) {
    return io_error(doing, error ? error.value() : ENOTDIR);
  }
  return success();
}

Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing) {
  if (::rename(from.c_str(), to.c_str()) != 0) return io_error(doing, errno);
  return success();
}

Result<std::vector<std::filesystem::path>> list_folder(const std::filesystem::path& folder,
                                                       const char* doing) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    paths.push_back(at->path());
  }
  if (error) return io_error(doing, error.value());
  return paths;
}

Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing) {
  auto opened = open_file(file, O_RDONLY, doing);
  if (!opened) return std::move(opened).error();
  struct stat status {};
  if (::fstat(opened->number(), &status) != 0) return io_error(doing, errno);
  // One byte more than there should be, to see the end; what a file says of its size may be less
  // than it has, as in /proc.
  const std::size_t most = limit + 1;
  std::string text(
      std::min(most, std::max(kLeastRead, static_cast<std::size_t>(status.st_size) + 1)), '\0');
  std::size_t filled = 0;
  for (;;) {
    const auto rest = std::as_writable_bytes(std::span(text)).subspan(filled);
    const auto size = read_at(*opened, filled, rest, doing);
    if (!size) return size.error();
    filled += *size;
    if (filled < text.size()) break;
    if (filled == most) {
      return Error{ErrorKind::kInternal, "STORE_DAMAGED",
                   std::string("cannot ") + doing + ": it is longer than any", ""};
    }
    text.resize(std::min(most, 2 * text.size()));
  }
  text.resize(filled);
  return text;
}

Result<std::size_t> read_at(const FileDescriptor& file, std::uint64_t offset,
                            std::span<std::byte> bytes, const char* doing) {
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::pread(file.number(), bytes.data() + filled, bytes.size() - filled,
                                static_cast<off_t>(offset + filled));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error(doing, errno);
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  return filled;
}

}  // namespace sightline
