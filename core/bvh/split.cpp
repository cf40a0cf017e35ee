#include "core/bvh/split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "core/base/column.h"
#include "core/base/parallel.h"

namespace sightline {

namespace {

/// Cells of the grid: a power of two, shared among the axes so that cells are about as long as
/// wide.
constexpr std::uint32_t kBits = 13;
constexpr std::uint32_t kCells = 1u << kBits;
constexpr std::uint16_t kNoCell = 0xffff;
/// Triangles or positions that one thread counts at a time: at least so many, and no more than so
/// many chunks, each of which has counters of its own.
constexpr std::size_t kChunk = 1u << 18;
constexpr std::size_t kChunks = 8;

/// So that no difference can overflow.
Vec3d halved(const Vec3d& p) { return {p.x / 2, p.y / 2, p.z / 2}; }

/// Cells are numbered along a Morton curve.
class Grid {
 public:
  /// `bounds` of the corners.
  explicit Grid(const Box3d& bounds) : low_(halved(bounds.min)) {
    Vec3d width;
    for (int k = 0; k < 3; ++k) width[k] = bounds.max[k] / 2 - low_[k];
    // The longest side of a cell is cut in two, again and again; the first cut is the highest bit.
    Vec3d cell = width;
    std::uint32_t bits[3] = {0, 0, 0};
    int axes[kBits];
    for (int& axis : axes) {
      axis = cell.y > cell.x ? 1 : 0;
      if (cell.z > cell[axis]) axis = 2;
      cell[axis] = cell[axis] / 2;
      ++bits[axis];
    }
    for (int k = 0; k < 3; ++k) {
      steps_[k].resize(std::size_t{1} << bits[k]);
      const auto side = static_cast<double>(steps_[k].size());
      scale_[k] = width[k] > 0 ? side / width[k] : 0;
      last_[k] = side - 1;
    }
    for (std::uint32_t i = 0; i < kBits; ++i) {
      const int axis = axes[i];
      --bits[axis];
      for (std::size_t step = 0; step < steps_[axis].size(); ++step) {
        const std::size_t bit = step >> bits[axis] & 1u;
        steps_[axis][step] |= static_cast<std::uint16_t>(bit << (kBits - 1 - i));
      }
    }
  }
  /// kNoCell unless the corner is finite.
  std::uint16_t cell(const Vec3d& corner) const {
    // Of a finite corner each difference is 0, of another one it is not a number.
    if (!((corner.x - corner.x) + (corner.y - corner.y) + (corner.z - corner.z) == 0))
      return kNoCell;
    std::uint32_t cell = 0;
    for (int k = 0; k < 3; ++k) {
      // Beyond the bounds lie positions that no triangle uses, and where the width nearly
      // underflows the place may be infinite or no number: any cell will do.
      const double place = std::max(0.0, (corner[k] / 2 - low_[k]) * scale_[k]);
      cell |=
          steps_[k][static_cast<std::size_t>(static_cast<std::int32_t>(std::min(last_[k], place)))];
    }
    return static_cast<std::uint16_t>(cell);
  }

 private:
  Vec3d low_;
  double scale_[3];
  double last_[3];
  std::vector<std::uint16_t> steps_[3];  ///< the bits of a cell's number that a step decides
};

/// Runs sorted by their cell.
struct Sorted {
  UnsetColumn<TriangleRun> runs;
  std::vector<std::uint32_t> ends;       ///< one for each cell: of its runs
  std::vector<std::uint32_t> triangles;  ///< likewise: how many
  std::vector<Box3d> boxes;              ///< likewise
};

/// What one thread knows.
struct Counted {
  std::vector<TriangleRun> runs;
  std::vector<std::uint16_t> cells;  ///< one for each run
  std::vector<std::uint32_t> next;   ///< from here on one for each cell: runs, then their place
  std::vector<std::uint32_t> triangles;
  std::vector<Box3d> boxes;
};

class Sorter {
 public:
  /// All must outlive it. `given` empty: all triangles of the mesh.
  Sorter(const MeshView& mesh, const Affine* world_from_mesh, std::span<const std::uint32_t> given,
         const Grid& grid)
      : mesh_(mesh), matrix_(world_from_mesh), given_(given), grid_(grid) {}

  Sorted sort() {
    if (given_.empty()) {
      place_positions();
      const std::uint16_t* const places = places_.data();
      find_runs(
          mesh_.triangle_count(), [](std::size_t i) { return static_cast<std::uint32_t>(i); },
          [places](std::uint32_t position) { return places[position]; });
    } else {
      find_runs(
          given_.size(), [this](std::size_t i) { return given_[i]; },
          [this](std::uint32_t position) { return grid_.cell(corner(position)); });
    }
    return collect();
  }

 private:
  /// Calls work(begin, end, counters of theirs) for parts of 0 .. count.
  template <class Work>
  void in_chunks(std::size_t count, const Work& work) {
    const std::size_t chunk = std::max(kChunk, (count + kChunks - 1) / kChunks);
    const std::size_t chunks = (count + chunk - 1) / chunk;
    if (counted_.size() < chunks) counted_.resize(chunks);
    parallel_for(chunks, [&](std::size_t c) {
      counted_[c].next.resize(kCells);
      counted_[c].triangles.resize(kCells);
      counted_[c].boxes.resize(kCells);
      work(c * chunk, std::min(count, (c + 1) * chunk), counted_[c]);
    });
  }

  Vec3d corner(std::uint32_t position) const {
    const Vec3f& p = mesh_.positions[position];
    if (matrix_ != nullptr) return matrix_->apply(p);
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
  }

  /// Most triangles of a large mesh have their three corners in one cell: their boxes are those of
  /// the positions, each of which several triangles share.
  void place_positions() {
    places_.resize(mesh_.positions.size());
    in_chunks(places_.size(), [&](std::size_t begin, std::size_t end, Counted& own) {
      // Neighbours mostly lie in one cell: its box stays in registers for a while.
      std::uint16_t cell = kNoCell;
      Box3d box;
      for (std::size_t i = begin; i < end; ++i) {
        const Vec3d p = corner(static_cast<std::uint32_t>(i));
        const std::uint16_t here = grid_.cell(p);
        places_[i] = here;
        if (here == kNoCell) continue;
        if (here != cell) {
          if (cell != kNoCell) own.boxes[cell].include(box);
          cell = here;
          box = {};
        }
        box.include(p);
      }
      if (cell != kNoCell) own.boxes[cell].include(box);
    });
  }

  template <class Number, class Place>
  void find_runs(std::size_t count, const Number& number, const Place& place) {
    in_chunks(count, [&](std::size_t begin, std::size_t end, Counted& own) {
      std::uint16_t cell = kNoCell;
      TriangleRun run{0, 0};
      const auto close = [&] {
        if (cell == kNoCell || run.count == 0) return;
        own.runs.push_back(run);
        own.cells.push_back(cell);
        ++own.next[cell];
        own.triangles[cell] += run.count;
      };
      const IndexView indices = mesh_.indices;
      const bool is_placed = !places_.empty();
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t triangle = number(i);
        const std::array<std::uint32_t, 3> at = indices.corners(triangle);
        const std::uint16_t a = place(at[0]), b = place(at[1]), c = place(at[2]);
        std::uint16_t here = a;
        if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) {
          here = kNoCell;
        } else if (a != b || b != c || !is_placed) {
          here = include_corners(own, {a, b, c}, at);
        }
        if (here != cell || triangle != run.first + run.count) {
          close();
          cell = here;
          run = {triangle, 0};
        }
        ++run.count;
      }
      close();
    });
  }

  /// Returns the cell of a triangle that lies in several, or whose positions are in no box.
  std::uint16_t include_corners(Counted& own, const std::array<std::uint16_t, 3>& places,
                                const std::array<std::uint32_t, 3>& at) const {
    if (std::find(places.begin(), places.end(), kNoCell) != places.end()) return kNoCell;
    const Vec3d a = corner(at[0]), b = corner(at[1]), c = corner(at[2]);
    const std::uint16_t cell = places[0];
    for (const Vec3d* p : {&a, &b, &c}) own.boxes[cell].include(*p);
    return cell;
  }

  /// What all threads found.
  Sorted collect() {
    Sorted sorted;
    sorted.ends.resize(kCells);
    sorted.triangles.resize(kCells);
    sorted.boxes.resize(kCells);
    constexpr std::size_t kRow = 1024;
    parallel_for(kCells / kRow, [&](std::size_t row) {
      for (std::size_t cell = row * kRow; cell < (row + 1) * kRow; ++cell) {
        for (const Counted& one : counted_) {
          sorted.triangles[cell] += one.triangles[cell];
          sorted.boxes[cell].include(one.boxes[cell]);
        }
      }
    });
    std::uint32_t end = 0;
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
      for (Counted& one : counted_) end += std::exchange(one.next[cell], end);
      sorted.ends[cell] = end;
    }
    sorted.runs.resize(end);
    parallel_for(counted_.size(), [&](std::size_t c) {
      Counted& own = counted_[c];
      for (std::size_t i = 0; i < own.runs.size(); ++i)
        sorted.runs[own.next[own.cells[i]]++] = own.runs[i];
    });
    return sorted;
  }

  const MeshView& mesh_;
  const Affine* const matrix_;
  const std::span<const std::uint32_t> given_;
  const Grid& grid_;
  UnsetColumn<std::uint16_t> places_;  ///< the cell of each position; empty: not known
  std::vector<Counted> counted_;
};

}  // namespace

std::vector<std::uint32_t> numbers_of(std::span<const TriangleRun> runs) {
  std::vector<std::uint32_t> numbers;
  for (const TriangleRun& run : runs) {
    for (std::uint32_t i = 0; i < run.count; ++i) numbers.push_back(run.first + i);
  }
  return numbers;
}

std::vector<MeshPart> split_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                                 std::span<const std::uint32_t> triangles, const Box3d& bounds) {
  const Grid grid(bounds);
  const auto sorted =
      std::make_shared<const Sorted>(Sorter(mesh, world_from_mesh, triangles, grid).sort());
  const std::span<const TriangleRun> runs(sorted->runs);
  std::vector<MeshPart> parts;
  MeshPart part{{}, 0, sorted, {}};
  std::uint32_t begin = 0, end = 0;
  const auto close = [&] {
    if (end == begin) return;
    part.runs = runs.subspan(begin, end - begin);
    // Positions that no triangle uses may lie beyond.
    for (int k = 0; k < 3; ++k) {
      part.box.min[k] = std::max(part.box.min[k], bounds.min[k]);
      part.box.max[k] = std::min(part.box.max[k], bounds.max[k]);
    }
    parts.push_back(std::move(part));
    part = {{}, 0, sorted, {}};
    begin = end;
  };
  // Neighbours along the curve go into one part while there is room.
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    if (sorted->ends[cell] == end) continue;
    if (part.triangle_count + sorted->triangles[cell] > kPartTriangles) close();
    end = sorted->ends[cell];
    part.triangle_count += sorted->triangles[cell];
    part.box.include(sorted->boxes[cell]);
  }
  close();
  return parts;
}

std::vector<TriangleRun> ascending(std::span<const TriangleRun> runs) {
  std::vector<TriangleRun> sorted(runs.begin(), runs.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const TriangleRun& a, const TriangleRun& b) { return a.first < b.first; });
  std::size_t last = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[last].first + sorted[last].count == sorted[i].first) {
      sorted[last].count += sorted[i].count;
    } else {
      sorted[++last] = sorted[i];
    }
  }
  if (!sorted.empty()) sorted.resize(last + 1);
  return sorted;
}

std::vector<MeshPart> cut_mesh(const MeshView& mesh, const Affine* world_from_mesh,
                               const MeshPart& whole, std::uint32_t most) {
  std::vector<MeshPart> cells;
  std::vector<TriangleRun> runs;
  MeshPart cell;
  const auto fits = [&](std::uint32_t count) {
    return std::uint64_t{cell.triangle_count} + count <= most;
  };
  const auto close = [&] {
    if (cell.triangle_count == 0) return;
    const auto memory = std::make_shared<const std::vector<TriangleRun>>(ascending(runs));
    cell.runs = *memory;
    cell.owner = memory;
    cells.push_back(std::exchange(cell, {}));
    runs.clear();
  };
  const std::vector<MeshPart> parts =
      split_mesh(mesh, world_from_mesh, numbers_of(whole.runs), whole.box);
  for (const MeshPart& part : parts) {
    if (part.triangle_count > most && parts.size() > 1) {
      // Many triangles in one cell of the grid: a finer one.
      close();
      std::vector<MeshPart> finer = cut_mesh(mesh, world_from_mesh, part, most);
      std::move(finer.begin(), finer.end(), std::back_inserter(cells));
      continue;
    }
    if (!fits(part.triangle_count)) close();
    for (TriangleRun run : part.runs) {
      // No grid separates the triangles of the only part: then their number decides.
      while (!fits(run.count)) {
        const std::uint32_t room = most - cell.triangle_count;
        if (room > 0) runs.push_back({run.first, room});
        cell.triangle_count = most;
        cell.box = part.box;
        close();
        run = {run.first + room, run.count - room};
      }
      runs.push_back(run);
      cell.triangle_count += run.count;
    }
    cell.box.include(part.box);
  }
  close();
  return cells;
}

}  // namespace sightline
