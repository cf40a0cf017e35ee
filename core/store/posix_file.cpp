#include "core/store/posix_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace sightline {

Error io_error(const char* doing, int number) {
  const bool full = number == ENOSPC || number == EDQUOT;
  return {full ? ErrorKind::kOutOfSpace : ErrorKind::kInternal, full ? "STORE_FULL" : "STORE_IO",
          std::string("cannot ") + doing + ": " + std::generic_category().message(number), ""};
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

Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                   const char* doing) {
  if (::rename(from.c_str(), to.c_str()) != 0) return io_error(doing, errno);
  return success();
}

Result<std::string> read_small_file(const std::filesystem::path& file, std::size_t limit,
                                    const char* doing) {
  auto opened = open_file(file, O_RDONLY, doing);
  if (!opened) return std::move(opened).error();
  std::string text(limit + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = ::read(opened->number(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error(doing, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > limit) return io_error(doing, EFBIG);
  text.resize(size);
  return text;
}

Result<MappedFile> MappedFile::map(const FileDescriptor& file, const char* doing) {
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return io_error(doing, errno);
  MappedFile mapped;
  mapped.size_ = static_cast<std::size_t>(status.st_size);
  // An empty file cannot be mapped, and has no bytes to show.
  if (mapped.size_ == 0) return mapped;
  void* data = ::mmap(nullptr, mapped.size_, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (data == MAP_FAILED) {
    mapped.size_ = 0;
    return io_error(doing, errno);
  }
  mapped.data_ = static_cast<const std::byte*>(data);
  return mapped;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace sightline
