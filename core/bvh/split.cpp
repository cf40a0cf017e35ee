#include "core/bvh/split.h"

#include <algorithm>
#include <array>

#include "core/base/column.h"
#include "core/base/parallel.h"
#include "core/bvh/tree_corners.h"

namespace sightline {

namespace {

/// Cells of the grid along an axis, and of all of it, numbered along a Morton curve.
constexpr std::uint32_t kSide = 32;
constexpr std::uint32_t kCells = kSide * kSide * kSide;
constexpr std::uint16_t kNoCell = 0xffff;
/// Triangles that one thread counts together.
constexpr std::size_t kChunk = 1u << 19;

/// Two zero bits before every bit of a number below kSide.
constexpr std::uint32_t spread(std::uint32_t x) {
  std::uint32_t out = 0;
  for (std::uint32_t bit = 0; bit < 5; ++bit) out |= (x >> bit & 1u) << (3 * bit);
  return out;
}

/// The middle of a triangle's box, halved so that no sum can overflow.
Vec3d center_of(const std::array<Vec3d, 3>& at) {
  Vec3d center;
  for (int k = 0; k < 3; ++k) {
    center[k] =
        std::min({at[0][k], at[1][k], at[2][k]}) / 4 + std::max({at[0][k], at[1][k], at[2][k]}) / 4;
  }
  return center;
}

/// In the units of center_of.
Vec3d halved(const Vec3d& p) { return {p.x / 2, p.y / 2, p.z / 2}; }

class Grid {
 public:
  /// `bounds` of the triangles.
  explicit Grid(const Box3d& bounds) : low_(halved(bounds.min)) {
    for (int k = 0; k < 3; ++k) {
      const double width = bounds.max[k] / 2 - low_[k];
      scale_[k] = width > 0 ? kSide / width : 0;
    }
    for (std::uint32_t i = 0; i < kSide; ++i) spread_[i] = spread(i);
  }
  std::uint16_t cell(const Vec3d& center) const {
    std::uint32_t cell = 0;
    for (int k = 0; k < 3; ++k) {
      const double place = (center[k] - low_[k]) * scale_[k];
      // Where the width nearly underflows the place may be infinite: any cell will do.
      const auto step = place > 0 ? static_cast<std::uint32_t>(std::min(place, kSide - 1.0)) : 0u;
      cell |= spread_[step] << k;
    }
    return static_cast<std::uint16_t>(cell);
  }

 private:
  Vec3d low_;
  double scale_[3];
  std::uint32_t spread_[kSide];
};

/// Triangles sorted by cell.
struct Sorted {
  Column<std::uint32_t> triangles;
  std::vector<std::uint32_t> ends;  ///< one for each cell
  std::vector<Box3d> boxes;         ///< likewise
};

/// What one thread knows of some triangles.
struct Counted {
  std::vector<std::uint32_t> next = std::vector<std::uint32_t>(kCells);
  std::vector<Box3d> boxes = std::vector<Box3d>(kCells);
};

Sorted sort_by_cell(const MeshView& mesh, const Affine* world_from_mesh,
                    std::span<const std::uint32_t> given, const Grid& grid) {
  const std::size_t count = given.empty() ? mesh.triangle_count() : given.size();
  const auto triangle = [&](std::size_t i) {
    return given.empty() ? static_cast<std::uint32_t>(i) : given[i];
  };
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  Column<std::uint16_t> cells(count);
  std::vector<Counted> counted(chunks);
  // Corners are read here and never again: they lie all over the mesh.
  parallel_for(chunks, [&](std::size_t chunk) {
    Counted& own = counted[chunk];
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      const TreeCorners corners = tree_corners(mesh, triangle(i), world_from_mesh);
      cells[i] = corners.usable ? grid.cell(center_of(corners.at)) : kNoCell;
      if (!corners.usable) continue;
      ++own.next[cells[i]];
      for (const Vec3d& p : corners.at) own.boxes[cells[i]].include(p);
    }
  });
  Sorted sorted;
  sorted.ends.resize(kCells);
  sorted.boxes.resize(kCells);
  std::uint32_t end = 0;
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    for (Counted& one : counted) {
      const std::uint32_t here = one.next[cell];
      if (here > 0) sorted.boxes[cell].include(one.boxes[cell]);
      one.next[cell] = end;
      end += here;
    }
    sorted.ends[cell] = end;
  }
  sorted.triangles.resize(end);
  parallel_for(chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      if (cells[i] != kNoCell) sorted.triangles[counted[chunk].next[cells[i]]++] = triangle(i);
    }
  });
  return sorted;
}

}  // namespace

std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles, const Box3d& bounds) {
  const Sorted sorted = sort_by_cell(mesh, world_from_mesh, triangles, Grid(bounds));
  // Neighbours along the curve go together while there is room.
  struct Range {
    std::uint32_t begin, end;
    Box3d box;
  };
  std::vector<Range> ranges;
  Range range{};
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    if (sorted.ends[cell] == range.end) continue;
    if (sorted.ends[cell] - range.begin > kPartTriangles && range.end > range.begin) {
      ranges.push_back(range);
      range = {range.end, range.end, {}};
    }
    range.end = sorted.ends[cell];
    range.box.include(sorted.boxes[cell]);
  }
  if (range.end > range.begin) ranges.push_back(range);

  std::vector<MeshPart> parts(ranges.size());
  parallel_for(ranges.size(), [&](std::size_t i) {
    parts[i].triangles.assign(sorted.triangles.begin() + ranges[i].begin,
                              sorted.triangles.begin() + ranges[i].end);
    parts[i].box = ranges[i].box;
  });
  return parts;
}

}  // namespace sightline
