#pragma once
/// RetainedBytes: parts of a file that are needed after its import, at their places.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace sightline::gltf {

/// Parts of a file: offset and length of each.
using FileParts = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
/// Returns the parts in ascending order, those that touch or overlap as one.
FileParts merged(FileParts parts);
/// The bytes of all parts. Precondition: they are merged.
std::uint64_t bytes_of(const FileParts& parts);

/// A copy of parts of a file, as long as the file. Only pages with a part take memory; all other
/// bytes are zero.
class RetainedBytes {
 public:
  /// Copies merged parts of `whole`, which must be inside of it. Throws std::bad_alloc.
  RetainedBytes(std::span<const std::byte> whole, const FileParts& parts);
  ~RetainedBytes();
  RetainedBytes(const RetainedBytes&) = delete;
  RetainedBytes& operator=(const RetainedBytes&) = delete;

  /// The place of the whole file.
  std::span<const std::byte> bytes() const { return {pages_, size_}; }

 private:
  std::byte* pages_;
  std::size_t size_;
};

}  // namespace sightline::gltf

// Tests: tests/integration/poses_test.py
