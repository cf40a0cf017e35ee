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
/// Triangles whose centres one thread bounds together.
constexpr std::size_t kGrain = 1u << 15;

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

Box3d center_bounds(const MeshView& mesh, const Affine* world_from_mesh,
                    std::span<const std::uint32_t> given) {
  return parallel_reduce(
      0, given.empty() ? mesh.triangle_count() : given.size(), kGrain, Box3d{},
      [&](std::size_t begin, std::size_t end, Box3d box) {
        for (std::size_t i = begin; i < end; ++i) {
          const TreeCorners corners = tree_corners(
              mesh, given.empty() ? static_cast<std::uint32_t>(i) : given[i], world_from_mesh);
          if (corners.usable) box.include(center_of(corners.at));
        }
        return box;
      },
      [](Box3d a, const Box3d& b) {
        a.include(b);
        return a;
      });
}

class Grid {
 public:
  explicit Grid(const Box3d& centers) : low_(centers.min) {
    for (int k = 0; k < 3; ++k) {
      const double width = centers.max[k] - low_[k];
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

/// Triangles sorted by cell, those of a cell in their order.
struct Sorted {
  Column<std::uint32_t> triangles;
  std::vector<std::uint32_t> ends;  ///< one for each cell
};

Sorted sort_by_cell(const MeshView& mesh, const Affine* world_from_mesh,
                    std::span<const std::uint32_t> given, const Grid& grid) {
  const std::size_t count = given.empty() ? mesh.triangle_count() : given.size();
  const auto triangle = [&](std::size_t i) {
    return given.empty() ? static_cast<std::uint32_t>(i) : given[i];
  };
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  Column<std::uint16_t> cells(count);
  std::vector<std::vector<std::uint32_t>> next(chunks);
  parallel_for(chunks, [&](std::size_t chunk) {
    next[chunk].assign(kCells, 0);
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      const TreeCorners corners = tree_corners(mesh, triangle(i), world_from_mesh);
      cells[i] = corners.usable ? grid.cell(center_of(corners.at)) : kNoCell;
      if (corners.usable) ++next[chunk][cells[i]];
    }
  });
  Sorted sorted;
  sorted.ends.resize(kCells);
  std::uint32_t end = 0;
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      const std::uint32_t here = next[chunk][cell];
      next[chunk][cell] = end;
      end += here;
    }
    sorted.ends[cell] = end;
  }
  sorted.triangles.resize(end);
  parallel_for(chunks, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      if (cells[i] != kNoCell) sorted.triangles[next[chunk][cells[i]]++] = triangle(i);
    }
  });
  return sorted;
}

}  // namespace

std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles) {
  const Grid grid(center_bounds(mesh, world_from_mesh, triangles));
  const Sorted sorted = sort_by_cell(mesh, world_from_mesh, triangles, grid);
  // Neighbours along the curve go together while there is room.
  struct Range {
    std::uint32_t begin, end;
  };
  std::vector<Range> ranges;
  std::uint32_t begin = 0, end = 0;
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    if (sorted.ends[cell] - begin > kPartTriangles && end > begin) {
      ranges.push_back({begin, end});
      begin = end;
    }
    end = sorted.ends[cell];
  }
  if (end > begin) ranges.push_back({begin, end});

  std::vector<MeshPart> parts(ranges.size());
  parallel_for(ranges.size(), [&](std::size_t i) {
    MeshPart& part = parts[i];
    part.triangles.assign(sorted.triangles.begin() + ranges[i].begin,
                          sorted.triangles.begin() + ranges[i].end);
    std::sort(part.triangles.begin(), part.triangles.end());
    for (const std::uint32_t triangle : part.triangles) {
      for (const Vec3d& p : tree_corners(mesh, triangle, world_from_mesh).at) part.box.include(p);
    }
  });
  return parts;
}

}  // namespace sightline
