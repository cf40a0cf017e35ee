#include "core/store/file_bytes.h"

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <optional>

#include "core/base/pages.h"
#include "core/base/parallel.h"

namespace sightline {
namespace {

/// A thread reads one piece at a time.
constexpr std::size_t kPiece = 4 << 20;

Status read_pieces(const FileDescriptor& file, std::span<std::byte> bytes, const char* doing) {
  std::mutex mutex;
  std::optional<Error> failure;
  parallel_for((bytes.size() + kPiece - 1) / kPiece, [&](std::size_t i) {
    const auto piece = bytes.subspan(i * kPiece, std::min(kPiece, bytes.size() - i * kPiece));
    const auto size = read_at(file, i * kPiece, piece, doing);
    if (size && *size == piece.size()) return;
    const std::lock_guard hold(mutex);
    failure = size ? io_error(doing, EIO) : size.error();
  });
  if (failure) return *std::move(failure);
  return success();
}

}  // namespace

Result<FileBytes> FileBytes::read(const FileDescriptor& file, const char* doing) {
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return io_error(doing, errno);
  FileBytes read;
  read.size_ = static_cast<std::size_t>(status.st_size);
  if (read.size_ < kSharedFrom) {
    read.small_.resize(read.size_);
    const auto size = read_at(file, 0, read.small_, doing);
    if (!size) return size.error();
    read.size_ = *size;
    return read;
  }
  try {
    read.pages_ = static_cast<std::byte*>(take_pages(read.size_));
  } catch (const std::bad_alloc&) {
    return io_error(doing, ENOMEM);
  }
  Status filled = read_pieces(file, {read.pages_, read.size_}, doing);
  if (!filled) return std::move(filled).error();
  return read;
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : pages_(std::exchange(other.pages_, nullptr)),
      small_(std::move(other.small_)),
      size_(std::exchange(other.size_, 0)),
      claims_(std::move(other.claims_)) {}

FileBytes::~FileBytes() {
  if (pages_ != nullptr) give_pages(pages_, size_);
}

void FileBytes::claim(std::span<const std::byte> part) const {
  const auto begin = static_cast<std::size_t>(part.data() - bytes().data());
  const std::lock_guard hold(mutex_);
  claims_.emplace_back(begin, begin + part.size());
}

void FileBytes::drop_unclaimed() const {
  if (pages_ == nullptr) return;
  const std::lock_guard hold(mutex_);
  std::sort(claims_.begin(), claims_.end());
  claims_.emplace_back(whole_pages(size_), whole_pages(size_));
  std::size_t kept_to = 0;
  for (const auto& [begin, end] : claims_) {
    const std::size_t first = whole_pages(kept_to);
    if (begin > first) {
      const std::size_t last = begin / whole_pages(1) * whole_pages(1);
      if (last > first) ::madvise(pages_ + first, last - first, MADV_DONTNEED);
    }
    kept_to = std::max(kept_to, end);
  }
  claims_ = {};
}

}  // namespace sightline
