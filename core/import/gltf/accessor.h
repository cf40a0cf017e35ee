#pragma once
/// Typed views of the numbers in a glTF file, every one of which lies inside the file's bytes.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/vec3.h"
#include "core/import/codec/decoded_elements.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/view_store.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// `count` elements of `components` numbers each. Reading is by value and needs no alignment.
struct AccessorView {
  std::uint32_t accessor = 0;  ///< its index, for messages
  std::uint64_t count = 0;
  Component component = Component::kF32;
  std::uint32_t components = 1;
  bool normalized = false;

  const std::byte* base = nullptr;  ///< nullptr: all zeros
  bool is_decoded = false;          ///< base does not lie in the file, it was decoded before
  std::size_t stride = 0;

  /// Replaced elements; their indices rise strictly and are below count.
  std::uint64_t sparse_count = 0;
  const std::byte* sparse_indices = nullptr;
  Component sparse_component = Component::kU32;
  const std::byte* sparse_values = nullptr;  ///< tightly packed

  std::size_t element_bytes() const;
  /// Packed float32 without replacements, as nearly every file has it.
  bool plain_float() const { return component == Component::kF32 && sparse_count == 0; }
};

/// An integer component as the file holds it. Precondition: not kF32.
std::int64_t load_integer(const std::byte* at, Component component);

/// One component as a number, in float64: a float32 widened; an integer, when `normalized`, by
/// glTF's formula [glTF2] 3.11: c / 255, c / 65535, max(c / 127, -1), max(c / 32767, -1).
double load_number(const std::byte* at, Component component, bool normalized);

/// Element `index` with its replacement, if it has one. Precondition: index < count, components >=
/// `wanted`; writes `wanted` numbers.
void load_element(const AccessorView& view, std::uint64_t index, std::uint32_t wanted, double* out);

/// The sparse entry that replaces element `index` or the first one after it.
std::uint64_t sparse_lower_bound(const AccessorView& view, std::uint64_t index);
std::uint64_t sparse_index(const AccessorView& view, std::uint64_t entry);

/// Makes views, and counts what is read through them.
class AccessorReader {
 public:
  AccessorReader(const GltfDocument& document, ViewStore& views, const ImportLimits& limits)
      : document_(document), views_(views), limits_(limits) {}

  ViewStore& views() const { return views_; }

  /// Checks view, offsets, stride, alignment, count and sparse parts against the bytes.
  /// Precondition: index is in range. Cost: sparse indices are read once.
  /// Errors: GLTF_ACCESSOR_INVALID, GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_LIMIT_ZERO_FILLED,
  /// those of ViewStore.
  Result<AccessorView> view(std::size_t index);

  /// A view of an accessor whose elements were decoded before. `decoded` must have as many elements
  /// as the accessor states, of the same type, and must outlive the view. Errors:
  /// GLTF_ACCESSOR_INVALID.
  Result<AccessorView> view(std::size_t index, const DecodedElements& decoded);

  /// A view of an accessor in a compressed bufferView, without reading bytes: `base` is null until
  /// the bufferView is decoded. The accessor's byteOffset counts from its beginning. Errors:
  /// GLTF_ACCESSOR_INVALID, GLTF_ACCESSOR_OUT_OF_BOUNDS.
  Result<AccessorView> view_to_decode(std::size_t index) const;

  /// A view of packed elements that a decoder will produce: `base` is null until then. Errors:
  /// GLTF_ACCESSOR_INVALID.
  Result<AccessorView> view_of_decoded(std::size_t index) const;

  /// Counts elements first .. first + count - 1 of a view as read, under `kind`. Returns those that
  /// lie in the file, for will_need.
  std::span<const std::byte> count(const AccessorView& view, std::uint64_t first,
                                   std::uint64_t count, std::uint64_t TouchedBytes::*kind);
  /// count() that also prefetches the file's pages. Call it before the elements are read.
  void announce(const AccessorView& view, std::uint64_t first, std::uint64_t count,
                std::uint64_t TouchedBytes::*kind);
  const TouchedBytes& touched() const { return touched_; }

 private:
  struct Extent {
    int view;
    std::uint64_t offset, count, element, stride_or_zero;
    std::size_t alignment;
  };
  /// The type that an accessor states for its elements, as if they were packed.
  AccessorView stated_type(std::size_t index) const;
  /// stated_type with the stride of its view. Checks the type and the stride.
  Result<AccessorView> stated(std::size_t index) const;
  Extent extent_of(std::size_t index, const AccessorView& view) const;
  /// Whether an extent lies in a view of so many bytes.
  Status check(std::size_t index, const char* part, const Extent& extent,
               std::uint64_t bytes) const;
  Result<const std::byte*> locate(std::size_t index, const char* part, const Extent& extent);
  Status attach_sparse(std::size_t index, AccessorView& view);

  const GltfDocument& document_;
  ViewStore& views_;
  const ImportLimits& limits_;
  TouchedBytes touched_;
};

}  // namespace sightline::gltf
