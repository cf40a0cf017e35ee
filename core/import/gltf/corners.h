#pragma once
/// Which vertices the triangles of a primitive join.

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/import/gltf/accessor.h"

namespace sightline::gltf {

/// How many triangles `count` indices (or vertices) make: triangles (4) n / 3, strips (5) and fans
/// (6) n - 2 or none.
std::uint64_t triangle_count(int mode, std::uint64_t count);

struct CornerRange {
  std::uint32_t low = 0, high = 0;  ///< smallest and largest vertex that a triangle uses
  std::size_t count() const { return std::size_t{high} - low + 1; }
};

/// Writes three vertices per triangle, unrolled as [glTF2] 3.7.2.1 orders them:
///   strip  i: v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]
///   fan    i: v[i + 1], v[i + 2], v[0]
/// indices   the index accessor, or nothing: then vertices 0 .. vertex_count - 1 in order.
/// Precondition: there is at least one triangle, vertex_count < 2^32.
/// Errors: GLTF_INDEX_OUT_OF_RANGE naming `place`.
Result<CornerRange> load_corners(const std::optional<AccessorView>& indices,
                                 std::uint64_t vertex_count, int mode, const std::string& place,
                                 std::uint32_t* out);

/// Those of plain triangles (4) as they lie in the file; empty where they are not to be had so.
SharedColumn<std::uint32_t> stored_corners(const AccessorView& indices, const SharedBytes& shared);

/// Their range. Precondition: there is at least one triangle. Errors: as above.
Result<CornerRange> check_corners(std::span<const std::uint32_t> corners,
                                  std::uint64_t vertex_count, const std::string& place);

}  // namespace sightline::gltf

// Tests: tests/unit/import/attribute_reader_test.cpp
