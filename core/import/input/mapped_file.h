#pragma once
/// A regular file mapped read-only. Only the pages that are touched are read.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/result.h"

namespace sightline::gltf {

class MappedFile {
 public:
  /// Errors: GLTF_FILE_UNREADABLE (absent, not a regular file, no permission),
  /// GLTF_LIMIT_FILE_BYTES. Messages call the file `name`, never by its path.
  static Result<MappedFile> open(const std::filesystem::path& path, std::uint64_t limit,
                                 const std::string& name);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return {data_, size_}; }

  /// From now on the system reads the pages that are touched, or announced by will_need, and none
  /// around them.
  void read_sparsely() const;

 private:
  MappedFile(const std::byte* data, std::size_t size) : data_(data), size_(size) {}
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Tells the system that all of these bytes are about to be read: bytes of a mapped file are
/// prefetched in one call. Other memory is not affected.
void will_need(std::span<const std::byte> bytes);

/// Reads every byte, in order.
void read_all(std::span<const std::byte> bytes);

}  // namespace sightline::gltf

// Tests: tests/unit/import/buffer_store_test.cpp
