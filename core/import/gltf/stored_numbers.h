#pragma once
/// Vertex attributes after the import: in the file's bytes, or compressed until a hit first
/// requests them.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/import/gltf/accessor.h"
#include "core/scene/vertex_numbers.h"

namespace sightline::gltf {

/// An attribute whose bytes are uncompressed.
class StoredNumbers : public VertexNumbers {
 public:
  /// view    holds the vertices from number `first` on
  /// owner   owns the bytes of the view; held as long as this object
  /// copied  how many of these bytes are a copy in memory, rather than bytes of the file
  StoredNumbers(const AccessorView& view, std::uint64_t first, std::shared_ptr<const void> owner,
                std::uint64_t copied)
      : view_(view), first_(first), owner_(std::move(owner)), copied_(copied) {}

  std::uint32_t components() const override { return view_.components; }
  bool load(std::uint64_t vertex, double* out, std::uint64_t& touched) const override {
    load_element(view_, vertex - first_, view_.components, out);
    if (copied_ == 0) touched += view_.element_bytes();
    return true;
  }
  std::uint64_t bytes() const override { return copied_; }

 private:
  AccessorView view_;
  std::uint64_t first_;
  std::shared_ptr<const void> owner_;
  std::uint64_t copied_;
};

/// A value that is decoded from compressed bytes when it is first requested, and then cached.
/// Thread-safe.
template <class Decoded>
class LateDecoded {
 public:
  using Decode = std::function<Result<Decoded>(std::span<const std::byte>)>;
  /// is_copied  false: `compressed` refers to the file's bytes
  /// decode     decodes the compressed bytes; called at most once with success or an error
  LateDecoded(SharedColumn<std::byte> compressed, bool is_copied, Decode decode)
      : compressed_(std::move(compressed)), is_copied_(is_copied), decode_(std::move(decode)) {}

  /// Returns the decoded value, valid while this object lives. Adds to `touched` the compressed
  /// bytes of the file that the call read. Null if the bytes cannot be decoded; later calls also
  /// return null. Throws std::bad_alloc; a later call tries again.
  const Decoded* get(std::uint64_t& touched) const {
    std::call_once(once_, [&] {
      if (!is_copied_) touched += compressed_.size();
      try {
        if (Result<Decoded> made = decode_(compressed_)) made_.emplace(*std::move(made));
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception&) {  // a library's: it has not been made
      }
    });
    return made_ ? &*made_ : nullptr;
  }
  /// Bytes of the compressed copy in memory; 0 if there is none.
  std::uint64_t bytes() const { return is_copied_ ? compressed_.size() : 0; }

 private:
  SharedColumn<std::byte> compressed_;
  bool is_copied_;
  Decode decode_;
  mutable std::once_flag once_;
  mutable std::optional<Decoded> made_;
};

/// An attribute whose bytes are decoded when a hit first requests them.
class LateNumbers : public VertexNumbers {
 public:
  /// Returns the first byte of the decoded elements, or null if they cannot be decoded. May throw
  /// std::bad_alloc.
  using Begin = std::function<const std::byte*(std::uint64_t& touched)>;
  /// bytes  size of the compressed bytes that are in memory
  LateNumbers(const AccessorView& view, Begin begin, std::uint64_t bytes)
      : view_(view), begin_(std::move(begin)), bytes_(bytes) {}

  std::uint32_t components() const override { return view_.components; }
  bool load(std::uint64_t vertex, double* out, std::uint64_t& touched) const override {
    AccessorView view = view_;
    view.base = begin_(touched);
    if (view.base == nullptr) return false;
    load_element(view, vertex, view.components, out);
    return true;
  }
  std::uint64_t bytes() const override { return bytes_; }

 private:
  AccessorView view_;
  Begin begin_;
  std::uint64_t bytes_;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/attribute_reader_test.cpp
