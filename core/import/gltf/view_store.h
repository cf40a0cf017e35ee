#pragma once
/// ViewStore: the bytes of a document's bufferViews. A view is a part of a buffer; if it has
/// EXT_meshopt_compression, it is decoded when first needed and stays in memory until the end of
/// the import.

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/import/gltf/buffer_store.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/budget.h"

namespace sightline::gltf {

/// The bufferViews of one document. Returned bytes are valid while this store and its BufferStore
/// live. Not thread-safe.
class ViewStore {
 public:
  /// All arguments must outlive the store.
  ViewStore(const GltfDocument& document, BufferStore& buffers, Budget& budget)
      : document_(document), buffers_(buffers), budget_(budget) {}

  /// Returns the byteLength bytes of a view. A compressed view is always decoded; uncompressed
  /// bytes that its buffer may have for other readers are ignored. Precondition: index is in range.
  /// Errors: GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_COMPRESSION_INVALID, GLTF_LIMIT_GEOMETRY_BYTES,
  /// those of BufferStore.
  Result<std::span<const std::byte>> bytes(std::size_t index);

  /// Returns the bytes of a view that hold a Draco-compressed primitive, counts them as read if
  /// they are in a file, and prefetches them. Errors: those of bytes().
  Result<std::span<const std::byte>> compressed(std::size_t index);

  /// Returns the compressed bytes of a view with EXT_meshopt_compression without decoding them.
  /// Precondition: is_meshopt(index). Errors: those of bytes().
  Result<std::span<const std::byte>> to_decode(std::size_t index);
  /// True if the view has EXT_meshopt_compression.
  bool is_meshopt(std::size_t index) const { return document_.meshopt.count(index) != 0; }

  /// BufferStore::is_at_hand for the buffer that has the view's bytes or its compressed bytes.
  bool is_at_hand(std::size_t index) const;
  /// True if the bytes are those of a file; false if they were decoded.
  bool is_mapped(std::size_t index) const;
  /// Total number of compressed bytes that were read from the file.
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
