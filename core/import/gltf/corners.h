#pragma once
/// Reads the vertex indices of the triangles of a primitive.

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/import/gltf/accessor.h"

namespace sightline::gltf {

/// The number of triangles that `count` indices (or vertices) form, by glTF's mode: triangles (4) n
/// / 3, strip (5) and fan (6) n - 2, at least 0.
std::uint64_t triangle_count(int mode, std::uint64_t count);

/// The range of vertices that triangles use.
struct CornerRange {
  std::uint32_t low = 0, high = 0;  ///< smallest and largest vertex that a triangle uses
  std::size_t count() const { return std::size_t{high} - low + 1; }
};

/// Writes three vertex indices per triangle to `out`, in the order of [glTF2] 3.7.2.1:
///   strip  triangle i: v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]
///   fan    triangle i: v[i + 1], v[i + 2], v[0]
/// indices  the index accessor; if empty, v is 0 .. vertex_count - 1
/// Returns the range of the indices. Preconditions: there is at least one triangle; vertex_count <
/// 2^32; `out` has room for all triangles. Errors: GLTF_INDEX_OUT_OF_RANGE naming `place`.
Result<CornerRange> load_corners(const std::optional<AccessorView>& indices,
                                 std::uint64_t vertex_count, int mode, const std::string& place,
                                 std::uint32_t* out);

/// The indices of a primitive of triangles (mode 4) as a column that refers to the file's bytes.
/// Empty unless they are 32-bit integers without sparse elements, in bytes that `shared` can share
/// (SharedBytes::share). The values are not checked: see check_corners. Precondition: the elements
/// are packed.
SharedColumn<std::uint32_t> stored_corners(const AccessorView& indices, const SharedBytes& shared);

/// Checks that all indices are below vertex_count, and returns the range of vertices that they use.
/// Precondition: there is at least one triangle. Errors: GLTF_INDEX_OUT_OF_RANGE naming `place`.
Result<CornerRange> check_corners(std::span<const std::uint32_t> corners,
                                  std::uint64_t vertex_count, const std::string& place);

}  // namespace sightline::gltf

// Tests: tests/unit/import/attribute_reader_test.cpp
