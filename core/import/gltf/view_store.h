#pragma once
/// The bytes behind a document's bufferViews: a part of a buffer as it stands, or what
/// EXT_meshopt_compression makes of one, decoded when first needed and held until the end of the
/// import.

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/import/gltf/buffer_store.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/budget.h"

namespace sightline::gltf {

class ViewStore {
 public:
  /// All three must outlive the store.
  ViewStore(const GltfDocument& document, BufferStore& buffers, Budget& budget)
      : document_(document), buffers_(buffers), budget_(budget) {}

  /// Exactly byteLength bytes. A view with the extension is always decoded; bytes that its buffer
  /// may have for other readers are ignored. Precondition: index is in range. Errors:
  /// GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_COMPRESSION_INVALID, GLTF_LIMIT_GEOMETRY_BYTES, those of
  /// BufferStore.
  Result<std::span<const std::byte>> bytes(std::size_t index);

  /// The bytes of a view that is compressed as the extension of a primitive says. Counts them as
  /// read.
  Result<std::span<const std::byte>> compressed(std::size_t index);

  /// What a view with EXT_meshopt_compression is decoded from, which is not done. Precondition:
  /// is_meshopt(index). Errors: those of bytes().
  Result<std::span<const std::byte>> to_decode(std::size_t index);
  bool is_meshopt(std::size_t index) const { return document_.meshopt.count(index) != 0; }

  /// BufferStore::is_at_hand of the buffer with its bytes, or with what they are decoded from.
  bool is_at_hand(std::size_t index) const;
  /// Whether reading this view reads the file, rather than what was decoded before.
  bool is_mapped(std::size_t index) const;
  /// How many compressed bytes of the file were read.
  std::uint64_t compressed_bytes() const { return compressed_bytes_; }

 private:
  Result<std::span<const std::byte>> decoded(std::size_t index, const MeshoptView& view);
  Result<std::span<const std::byte>> part(std::size_t buffer, std::uint64_t offset,
                                          std::uint64_t length, const std::string& place,
                                          const std::string& pointer);

  const GltfDocument& document_;
  BufferStore& buffers_;
  Budget& budget_;
  std::map<std::size_t, std::unique_ptr<std::byte[]>> decoded_;
  std::uint64_t compressed_bytes_ = 0;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/accessor_test.cpp
