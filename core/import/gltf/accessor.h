#pragma once
/// AccessorView: a typed view of the elements of a glTF accessor. AccessorReader has checked that
/// all bytes of a view are inside of the file, of another buffer, or of decoded memory.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
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

/// `count` elements of `components` numbers each, in memory that must outlive the view. Elements
/// are read by value, so they need no alignment.
struct AccessorView {
  std::uint32_t accessor = 0;  ///< index of the accessor, for messages
  std::uint64_t count = 0;
  Component component = Component::kF32;
  std::uint32_t components = 1;
  bool normalized = false;

  const std::byte* base = nullptr;  ///< first byte of the elements; nullptr: all are zero
  bool is_decoded = false;          ///< true: base points to decoded bytes, not to the file
  /// Bytes from an element to the next one.
  std::size_t stride = 0;

  /// Sparse accessor: these elements replace others. Their indices rise strictly and are below
  /// count.
  std::uint64_t sparse_count = 0;
  const std::byte* sparse_indices = nullptr;
  Component sparse_component = Component::kU32;
  const std::byte* sparse_values = nullptr;  ///< tightly packed

  /// Bytes of one element: its components without padding.
  std::size_t element_bytes() const;
  /// True for float32 numbers without sparse elements, which nearly every file has.
  bool plain_float() const { return component == Component::kF32 && sparse_count == 0; }
};

/// Reads an integer component as stored. Precondition: component is not kF32.
std::int64_t load_integer(const std::byte* at, Component component);

/// Reads the component at `at` as a number in float64. A float32 is widened. An integer c is
/// converted exactly or, if `normalized`, by the formula of [glTF2] 3.11. That is c / 255 for u8, c
/// / 65535 for u16, max(c / 127, -1) for i8, max(c / 32767, -1) for i16; by analogy c / 4294967295
/// for u32.
double load_number(const std::byte* at, Component component, bool normalized);

/// Reads element `index`, or its sparse replacement, and writes its first `wanted` numbers to
/// `out`. Preconditions: index < count, components >= wanted.
void load_element(const AccessorView& view, std::uint64_t index, std::uint32_t wanted, double* out);

/// Returns the number of the first sparse entry whose element is at least `index`; sparse_count if
/// there is none.
std::uint64_t sparse_lower_bound(const AccessorView& view, std::uint64_t index);
/// The element that sparse entry `entry` replaces. Precondition: entry < sparse_count.
std::uint64_t sparse_index(const AccessorView& view, std::uint64_t entry);

/// Makes views of a document's accessors, and counts the bytes that are read through them. A view
/// is valid while the ViewStore lives. Not thread-safe.
class AccessorReader {
 public:
  /// All arguments must outlive the reader.
  AccessorReader(const GltfDocument& document, ViewStore& views, const ImportLimits& limits)
      : document_(document), views_(views), limits_(limits) {}

  /// The store that the reader was made with.
  ViewStore& views() const { return views_; }

  /// Returns a view of an accessor. Checks its bufferView, offsets, stride, alignment in the
  /// bufferView, count and sparse parts against the bytes. Precondition: index is in range. Cost:
  /// sparse indices are read once. Errors: GLTF_ACCESSOR_INVALID, GLTF_ACCESSOR_OUT_OF_BOUNDS,
  /// GLTF_LIMIT_ZERO_FILLED, those of ViewStore.
  Result<AccessorView> view(std::size_t index);

  /// Returns a view of elements that are decoded already. `decoded` must have the number and type
  /// of elements that the accessor states, and must outlive the view. Errors:
  /// GLTF_ACCESSOR_INVALID.
  Result<AccessorView> view(std::size_t index, const DecodedElements& decoded);

  /// Returns a view of an accessor in a compressed bufferView without reading bytes: `base` is
  /// null, and the caller sets it when the bufferView is decoded. The accessor's byteOffset counts
  /// from the first decoded byte. Errors: GLTF_ACCESSOR_INVALID, GLTF_ACCESSOR_OUT_OF_BOUNDS.
  Result<AccessorView> view_to_decode(std::size_t index);

  /// Returns a view of packed elements that a decoder will produce: `base` is null, and the caller
  /// sets it after decoding. Errors: GLTF_ACCESSOR_INVALID.
  Result<AccessorView> view_of_decoded(std::size_t index) const;

  /// Counts elements first .. first + count - 1 of a view as read, in the member `kind` of
  /// touched(); sparse entries are counted in full. Returns the bytes of the elements in the file,
  /// for will_need (mapped_file.h); empty if they are not in a file.
  std::span<const std::byte> count(const AccessorView& view, std::uint64_t first,
                                   std::uint64_t count, std::uint64_t TouchedBytes::*kind);
  /// Calls count() and prefetches the pages of the result. To be called before the elements are
  /// read.
  void announce(const AccessorView& view, std::uint64_t first, std::uint64_t count,
                std::uint64_t TouchedBytes::*kind);
  /// The bytes that were counted so far.
  const TouchedBytes& touched() const { return touched_; }
  /// The bufferViews of views so far that start at a byte of their buffer that is no multiple of
  /// the size of a component. Their elements are read as they stand.
  const std::set<int>& unaligned() const { return unaligned_; }

 private:
  /// Where elements are in a bufferView, in bytes.
  struct Extent {
    int view;                                              ///< index of the bufferView
    std::uint64_t offset, count, element, stride_or_zero;  ///< stride 0: packed
    std::size_t alignment;  ///< of the first element and of the stride
  };
  /// The view that the accessor declares: count and element type, with the stride of packed elements.
  /// `base` is null and there are no sparse elements. Nothing is checked.
  AccessorView stated_type(std::size_t index) const;
  /// stated_type with the stride of the accessor's bufferView. Checks the type and the stride.
  Result<AccessorView> stated(std::size_t index) const;
  Extent extent_of(std::size_t index, const AccessorView& view) const;
  /// Checks that an extent is inside of a bufferView of `bytes` bytes, and that it is aligned.
  /// `index` is the accessor, `part` its part for messages: "" or " (sparse.indices)". Errors:
  /// GLTF_ACCESSOR_OUT_OF_BOUNDS, GLTF_ACCESSOR_INVALID (alignment). Precondition: count > 0.
  Status check(std::size_t index, const char* part, const Extent& extent, std::uint64_t bytes);
  /// The first byte of an extent, after check(). Errors: those of check() and of ViewStore.
  Result<const std::byte*> locate(std::size_t index, const char* part, const Extent& extent);
  Status attach_sparse(std::size_t index, AccessorView& view);

  const GltfDocument& document_;
  ViewStore& views_;
  const ImportLimits& limits_;
  TouchedBytes touched_;
  std::set<int> unaligned_;
};

}  // namespace sightline::gltf
