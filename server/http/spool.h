#pragma once
/// Spool: temporary files of request bodies and answers that wait for their clients.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// The folder of all temporary files, and the sum of their bytes. Thread-safe; must outlive its
/// files.
class Spool {
 public:
  /// folder  where the files are made; they have no names there
  /// limit   the most bytes of all files
  Spool(std::string folder, std::uint64_t limit) : folder_(std::move(folder)), limit_(limit) {}
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  /// Counts `bytes` more for a file that has `size` bytes now. Returns false, and counts nothing,
  /// if they do not fit. The last eighth of the limit is reserved for small files.
  bool take(std::uint64_t bytes, std::uint64_t size);
  /// Gives back bytes that take() counted.
  void give(std::uint64_t bytes) { used_ -= bytes; }
  /// Bytes of all files.
  std::uint64_t used() const { return used_; }
  /// True if a file of `size` bytes is small: at most a 1024th of the limit.
  bool is_small(std::uint64_t size) const { return size <= limit_ / 1024; }
  const std::string& folder() const { return folder_; }

 private:
  const std::string folder_;
  const std::uint64_t limit_;
  std::atomic<std::uint64_t> used_{0};
};

/// An unlinked temporary file. The first append makes it, the destructor removes it. Not
/// thread-safe.
class SpoolFile {
 public:
  explicit SpoolFile(Spool& spool) : spool_(spool) {}
  ~SpoolFile();
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  /// Appends bytes. Returns false if the spool or its disk has no room; the file is then unchanged.
  bool append(std::string_view bytes);
  /// Removes the file; the next append makes a new one.
  void clear();
  /// Reads at most `size` bytes from `offset`. Returns fewer only at the end of the file or if the
  /// disk fails.
  std::size_t read(std::uint64_t offset, char* data, std::size_t size) const;
  /// Size in bytes.
  std::uint64_t size() const { return size_; }
  /// The file descriptor; -1 before the first append and after clear().
  int descriptor() const { return descriptor_; }

  /// Checks that files can be made in a folder. Errors: SPOOL_UNUSABLE, with the text of the
  /// system.
  static Status can_be_made_in(const std::string& folder);

 private:
  Spool& spool_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace sightline

// Tests: tests/integration/slow_bodies_test.py
