#include "core/store/file_bytes.h"

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <optional>
#include <string>

#include "core/base/content_hash.h"
#include "core/base/parallel.h"

namespace sightline {
namespace {

/// Read, then hashed while it is in the cache of its processor.
constexpr std::size_t kCached = 256 << 10;

/// Fills `bytes` from the byte `offset` of the file on, and adds them to `hash` if there is one.
Status read_piece(const FileDescriptor& file, std::uint64_t offset, std::span<std::byte> bytes,
                  const char* doing, ContentHash* hash) {
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(kCached, bytes.size()));
    const auto size = read_at(file, offset, part, doing);
    if (!size) return size.error();
    if (*size < part.size()) return io_error(doing, EIO);
    if (hash != nullptr) hash->add(part);
    offset += part.size();
    bytes = bytes.subspan(part.size());
  }
  return success();
}

/// Each piece by one thread.
Status read_pieces(const FileDescriptor& file, std::span<std::byte> bytes, const char* doing,
                   std::uint64_t* fingerprint) {
  std::vector<std::uint64_t> hashes((bytes.size() + kHashPiece - 1) / kHashPiece);
  std::mutex mutex;
  std::optional<Error> failure;
  parallel_for(hashes.size(), [&](std::size_t i) {
    const std::size_t begin = i * kHashPiece;
    const auto piece = bytes.subspan(begin, std::min(kHashPiece, bytes.size() - begin));
    ContentHash hash;
    Status filled = read_piece(file, begin, piece, doing, fingerprint != nullptr ? &hash : nullptr);
    hashes[i] = hash.value();
    if (filled) return;
    const std::lock_guard hold(mutex);
    failure = std::move(filled).error();
  });
  if (failure) return *std::move(failure);
  if (fingerprint != nullptr) *fingerprint = hash_of(std::as_bytes(std::span(hashes)));
  return success();
}

}  // namespace

Result<FileBytes> FileBytes::read(const FileDescriptor& file, const char* doing) {
  return read(file, doing, nullptr, {});
}

Result<FileBytes> FileBytes::read(const FileDescriptor& file, const char* doing,
                                  std::uint64_t& fingerprint, const OverflowFor& overflow_for) {
  return read(file, doing, &fingerprint, overflow_for);
}

Result<FileBytes> FileBytes::read(const FileDescriptor& file, const char* doing,
                                  std::uint64_t* fingerprint, const OverflowFor& overflow_for) {
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return io_error(doing, errno);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size >= kSharedFrom) {
    const auto fill = [&](std::span<std::byte> room) {
      return read_pieces(file, room, doing, fingerprint);
    };
    return make(size, doing, fill, overflow_for);
  }
  FileBytes read;
  read.small_.resize(size);
  const auto got = read_at(file, 0, read.small_, doing);
  if (!got) return got.error();
  read.size_ = *got;
  if (fingerprint != nullptr) *fingerprint = hash_in_pieces(read.bytes());
  return read;
}

Result<FileBytes> FileBytes::make(std::size_t size, const char* doing,
                                  const std::function<Status(std::span<std::byte>)>& fill,
                                  const OverflowFor& overflow_for) {
  FileBytes made;
  made.size_ = size;
  const auto overflow = overflow_for && size >= kSharedFrom ? overflow_for(size) : nullptr;
  try {
    if (size < kSharedFrom) {
      made.small_.resize(size);
    } else if (overflow) {
      made.overflow_ = overflow;
      made.piece_ = overflow->take(size);
      made.pages_ = made.piece_.get();
      if (made.pages_ == nullptr) {
        return Error{
            ErrorKind::kOutOfSpace, "OVERFLOW_FULL",
            std::string("cannot ") + doing +
                ": it exceeds the memory budget, and the temporary files for the rest have "
                "no room for it",
            ""};
      }
    } else {
      made.pages_ = static_cast<std::byte*>(take_pages(size));
    }
  } catch (const std::bad_alloc&) {
    return io_error(doing, ENOMEM);
  }
  std::byte* const begin = made.pages_ != nullptr ? made.pages_ : made.small_.data();
  if (Status filled = fill({begin, size}); !filled) return std::move(filled).error();
  return made;
}

Result<FileBytes> FileBytes::adopt(OwnedPages pages, std::size_t size, const char* doing,
                                   const OverflowFor& overflow_for) {
  if (size < kSharedFrom || (overflow_for && overflow_for(size) != nullptr)) {
    const auto copy = [&](std::span<std::byte> room) {
      std::copy_n(pages.get(), size, room.data());
      return success();
    };
    return make(size, doing, copy, overflow_for);
  }
  FileBytes adopted;
  adopted.size_ = size;
  const std::size_t used = whole_pages(size), taken = pages.get_deleter().bytes;
  adopted.pages_ = pages.release();
  if (taken > used) give_pages(adopted.pages_ + used, taken - used);
  return adopted;
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : pages_(std::exchange(other.pages_, nullptr)),
      overflow_(std::move(other.overflow_)),
      piece_(std::move(other.piece_)),
      small_(std::move(other.small_)),
      size_(std::exchange(other.size_, 0)),
      claims_(std::move(other.claims_)) {}

FileBytes::~FileBytes() {
  if (pages_ != nullptr && overflow_ == nullptr) give_pages(pages_, size_);
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
      if (last > first && overflow_ != nullptr) {
        overflow_->give_back(pages_ + first, last - first);
      } else if (last > first) {
        ::madvise(pages_ + first, last - first, MADV_DONTNEED);
      }
    }
    kept_to = std::max(kept_to, end);
  }
  claims_ = {};
}

}  // namespace sightline
