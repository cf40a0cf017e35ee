#pragma once
/// MappedFile: a regular file mapped read-only. The system reads only the pages that are accessed.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/result.h"

namespace sightline::gltf {

/// The mapping of one file; the destructor unmaps it.
class MappedFile {
 public:
  /// Maps a file of at most `limit` bytes. Messages name it `name` and do not contain its path.
  /// Errors: GLTF_FILE_UNREADABLE (absent, not a regular file, no permission),
  /// GLTF_LIMIT_FILE_BYTES.
  static Result<MappedFile> open(const std::filesystem::path& path, std::uint64_t limit,
                                 const std::string& name);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  /// The content of the file, valid while the mapping lives; moving this object does not move the
  /// bytes. If the file is truncated meanwhile, an access behind its end is the signal SIGBUS.
  std::span<const std::byte> bytes() const { return {data_, size_}; }

  /// Turns off the prefetching of neighbours: from now on the system reads only pages that are
  /// accessed or announced by will_need.
  void read_sparsely() const;

 private:
  MappedFile(const std::byte* data, std::size_t size) : data_(data), size_(size) {}
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Tells the system that these bytes will be read soon. It prefetches them if they are in a mapped
/// file; there is no effect on other memory.
void will_need(std::span<const std::byte> bytes);

/// Reads every byte, in order, and discards it.
void read_all(std::span<const std::byte> bytes);

}  // namespace sightline::gltf

// Tests: tests/unit/import/buffer_store_test.cpp
