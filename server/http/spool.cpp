#include "server/http/spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/base/unlinked_file.h"

namespace sightline {

bool Spool::take(std::uint64_t bytes, std::uint64_t size) {
  const std::uint64_t most = is_small(size + bytes) ? limit_ : limit_ - limit_ / 8;
  std::uint64_t used = used_;
  do {
    if (bytes > most || used > most - bytes) return false;
  } while (!used_.compare_exchange_weak(used, used + bytes));
  return true;
}

SpoolFile::~SpoolFile() { clear(); }

void SpoolFile::clear() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  spool_.give(size_);
  size_ = 0;
}

bool SpoolFile::append(std::string_view bytes) {
  if (!spool_.take(bytes.size(), size_)) return false;
  if (descriptor_ < 0) descriptor_ = make_unlinked_file(spool_.folder());
  std::uint64_t end = size_;
  std::string_view rest = bytes;
  while (descriptor_ >= 0 && !rest.empty()) {
    const ssize_t count = ::pwrite(descriptor_, rest.data(), rest.size(), static_cast<off_t>(end));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    end += static_cast<std::uint64_t>(count);
    rest.remove_prefix(static_cast<std::size_t>(count));
  }
  if (!rest.empty() || descriptor_ < 0) {
    spool_.give(bytes.size());
    return false;
  }
  size_ = end;
  return true;
}

std::size_t SpoolFile::read(std::uint64_t offset, char* data, std::size_t size) const {
  std::size_t got = 0;
  while (got < size && descriptor_ >= 0) {
    const ssize_t count =
        ::pread(descriptor_, data + got, size - got, static_cast<off_t>(offset + got));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    got += static_cast<std::size_t>(count);
  }
  return got;
}

Status SpoolFile::can_be_made_in(const std::string& folder) {
  const int file = make_unlinked_file(folder);
  const int error = errno;
  if (file < 0) {
    return Error{ErrorKind::kInvalid, "SPOOL_UNUSABLE",
                 "no temporary file can be made in '" + folder +
                     "': " + std::generic_category().message(error),
                 ""};
  }
  ::close(file);
  return success();
}

}  // namespace sightline
