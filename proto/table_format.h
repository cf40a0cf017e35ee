#pragma once
/// The formats of hits as a table for other programs. docs/reference/tables.md describes each.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

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

}  // namespace sightline

// Tests: tests/integration/tables_test.py
