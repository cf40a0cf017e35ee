#pragma once
/// The formats of hits as a table for other programs. docs/reference/tables.md describes each.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "proto/hit_fields.h"

namespace sightline {

/// The formats. PLY and PCD are point clouds: they have a row for each hit, with its position. The
/// others have a row for each slot, misses included.
enum class TableFormat : std::uint8_t { kCsv, kPly, kPcd, kNpy, kNpz };
inline constexpr std::array<std::string_view, 5> kTableMediaTypes{
    "text/csv", "application/x-ply", "application/x-pcd", "application/x-npy", "application/x-npz"};

constexpr std::string_view table_media_type(TableFormat format) {
  return kTableMediaTypes[static_cast<std::size_t>(format)];
}
constexpr bool is_point_cloud(TableFormat format) {
  return format == TableFormat::kPly || format == TableFormat::kPcd;
}

/// The most rows of an .npz file with these fields, `named` of which the file names: a ZIP archive
/// states sizes in 32 bits.
inline std::uint64_t most_npz_rows(FieldSet fields, std::size_t named = 0) {
  constexpr std::uint64_t kArchiveBytes = 0xffff0000u;
  return kArchiveBytes / (1 + 8 * numbers_of(fields, named));
}

}  // namespace sightline

// Tests: tests/integration/tables_test.py
// Tests: tests/unit/proto/table_format_test.cpp
