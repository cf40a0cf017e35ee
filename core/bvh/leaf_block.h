#pragma once
/// LeafBlock: a block of up to four triangles in a leaf of a tree, 96 to 160 bytes. A lane is the
/// place of one of these triangles, 0 to 3. In a top tree, lanes name placements.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/geometry/vec3.h"

namespace sightline {

/// The lanes of a block.
inline constexpr int kLanes = 4;

/// Up to four triangles of one placement. Lanes from lane_count() on repeat lane 0 and must be
/// ignored. Triangles share vertices: a block has a capacity of 6 or 8 vertices, and numbers that
/// say which of them the corners are. A block with a capacity of 12 has a vertex for each corner.
/// Blocks of a top tree have no vertices.
///
///     capacity      0    6    8   12
///     words         0    0    0    0   the offset in bytes of the two words below
///     numbers            16   16       64 bits: the three from 3 (4 corner + lane) on are the
///                                      number of a corner's vertex
///     vertices           24   24   16  as columns: float32 x[capacity], y, z in mesh space, as the
///                                      file has them
///     size         32   96  128  160
///
/// With a capacity of 12, corner c of lane i is vertex 4 c + i. Kernels load eight float32 from
/// each column of a block with numbers, so they read 8 bytes behind a block of 96. Builders call
/// set_capacity(), write the vertices, then call set_vertex_numbers() if there are numbers,
/// set_names() and set_edge_max().
///
/// The words hold these fields, from their lowest bit on:
///     placement is 0   triangle[0] 32, difference[1] 20 low bits, edge_max 12
///                      difference[2] 26, difference[3] 26, difference[1] 6 high bits,
///                      capacity 2, lane_count 3, a zero
///     placement > 0    triangle[0] 26, difference[1] 18, difference[3] 8 low bits, edge_max 12
///                      difference[2] 18, difference[3] 10 high bits, placement 24, zeros,
///                      capacity 2, lane_count 3, a one
/// difference[i] is triangle[i] - triangle[0]. For placement 0 it has a sign; for others
/// triangle[0] is the smallest. edge_max holds the upper half of a float32 without its sign,
/// rounded up. capacity is 0, 1, 2 or 3 for 0, 12, 6 or 8 vertices.
struct alignas(32) LeafBlock {
  /// Numbers of triangles of placements > 0 are below this; those of placement 0 have 32 bits.
  static constexpr std::uint64_t kTriangles = 1u << 26;
  static constexpr std::uint32_t kDifferences = 1u << 18;  ///< differences of placements > 0
  static constexpr std::uint32_t kNear = 1u << 25;         ///< |difference| of placement 0
  static constexpr std::uint32_t kPlacements = 1u << 24;   ///< numbers of placements are below this
  static constexpr std::uint32_t kMostVertices = 12;       ///< the most vertices of a block
  static constexpr std::uint32_t kMostGranules = 5;        ///< units of 32 bytes of such a block

  /// the packed fields; vertices follow in memory
  std::uint64_t word[2];

  /// The size of a block with this capacity (0, 6, 8 or 12 vertices), in units of 32 bytes.
  static constexpr std::uint32_t granules_for(std::uint32_t capacity) {
    return ((capacity == 6 || capacity == 8 ? 24 : 16) + 12 * capacity + 31) / 32;
  }
  /// The size of the block in units of 32 bytes.
  std::uint32_t granules() const { return has_numbers() ? 3 + is_larger() : 1 + 4 * is_larger(); }
  /// The block behind this one in a leaf.
  const LeafBlock* next() const { return this + granules(); }
  LeafBlock* next() { return this + granules(); }
  /// The number of vertices in memory, unused ones included: 0, 6, 8 or 12.
  std::uint32_t capacity() const { return has_numbers() ? 6 + 2 * is_larger() : 12 * is_larger(); }
  /// True if the block has vertex_numbers(): capacity() is 6 or 8.
  bool has_numbers() const { return (word[1] >> 59 & 1u) != 0; }
  /// Coordinates of the vertices on an axis (0 to 2). Precondition: capacity() > 0.
  const float* vertices(std::size_t axis) const {
    return reinterpret_cast<const float*>(word + (has_numbers() ? 3 : 2)) + axis * capacity();
  }
  float* vertices(std::size_t axis) {
    return reinterpret_cast<float*>(word + (has_numbers() ? 3 : 2)) + axis * capacity();
  }
  /// The numbers of the corners' vertices. Precondition: has_numbers().
  std::uint64_t vertex_numbers() const {
    std::uint64_t numbers = 0;
    std::memcpy(&numbers, word + 2, sizeof numbers);
    return numbers;
  }
  /// The vertex of a corner (0 to 2) of a lane. Precondition: capacity() > 0.
  std::uint32_t vertex(std::size_t corner, std::size_t lane) const {
    const std::size_t place = corner * kLanes + lane;
    return static_cast<std::uint32_t>(has_numbers() ? vertex_numbers() >> 3 * place & 7u : place);
  }
  /// The position of a corner of a lane, in mesh space. Precondition: capacity() > 0.
  Vec3f corner(std::size_t corner, std::size_t lane) const {
    const std::uint32_t i = vertex(corner, lane);
    return {vertices(0)[i], vertices(1)[i], vertices(2)[i]};
  }

  /// The number of a lane's triangle in its mesh. In a top tree: the index of an entry in
  /// SceneTree::placements. Precondition: lane < 4.
  std::uint32_t triangle(std::size_t lane) const {
    if (!is_behind()) {
      const std::uint32_t first = bits(0, 0, 32);
      if (lane == 0) return first;
      const std::uint32_t difference =
          lane == 1 ? bits(0, 32, 20) | bits(1, 52, 6) << 20 : bits(1, (lane - 2) * 26, 26);
      return first + ((difference ^ kNear) - kNear);
    }
    const std::uint32_t first = bits(0, 0, 26);
    if (lane == 0) return first;
    if (lane == 1) return first + bits(0, 26, 18);
    return first + (lane == 2 ? bits(1, 0, 18) : bits(0, 44, 8) | bits(1, 18, 10) << 8);
  }
  /// triangle() of all lanes.
  std::array<std::uint32_t, kLanes> triangles() const {
    return {triangle(0), triangle(1), triangle(2), triangle(3)};
  }
  /// The number of lanes in use, 1 to 4.
  std::uint32_t lane_count() const { return bits(1, 60, 3); }
  /// In a tree that several placements share: the index of the placement, counted from the entry
  /// that rays enter (SceneTree::placements). 0 in other trees.
  std::uint32_t placement() const { return is_behind() ? bits(1, 28, 24) : 0; }
  /// An upper bound of |x|, |y| and |z| of all edges of the triangles, in mesh space.
  float edge_max() const {
    return std::bit_cast<float>(static_cast<std::uint32_t>(word[0] >> 52) << 19);
  }

  /// True if triangles of one placement can share a block, given the least and the greatest of
  /// their numbers.
  static bool fit(std::uint32_t least, std::uint32_t greatest, std::uint32_t of_placement) {
    return greatest - least < (of_placement == 0 ? kNear : kDifferences);
  }
  /// Sets capacity(): 0, 6, 8 or 12. The vertices are then unspecified.
  void set_capacity(std::uint32_t capacity) {
    const std::uint64_t larger = capacity == 8 || capacity == 12 ? 1 : 0;
    const std::uint64_t numbers = capacity == 6 || capacity == 8 ? 1 : 0;
    word[1] = (word[1] & ~kCapacityBits) | larger << 58 | numbers << 59;
  }
  /// Sets vertex_numbers(). Precondition: has_numbers(); each number is below capacity().
  void set_vertex_numbers(std::uint64_t numbers) {
    std::memcpy(word + 2, &numbers, sizeof numbers);
  }
  /// Sets the triangles' numbers, lane_count (`count`) and placement; edge_max and capacity are
  /// unchanged. named[i] repeats named[0] from `count` on. Preconditions: the numbers are below
  /// their limits, 1 <= count <= 4, fit() holds; if of_placement > 0, named[0] is the least number.
  void set_names(const std::array<std::uint32_t, kLanes>& named, std::uint32_t count,
                 std::uint32_t of_placement) {
    constexpr std::uint64_t kOne = 1;
    const auto difference = [&](std::size_t lane) {
      const std::uint32_t bits = (of_placement == 0 ? 2 * kNear : kDifferences) - 1;
      return std::uint64_t{(named[lane] - named[0]) & bits};
    };
    const std::uint64_t edge = word[0] >> 52 << 52;
    const std::uint64_t lanes = std::uint64_t{count} << 60 | (word[1] & kCapacityBits);
    if (of_placement == 0) {
      word[0] = named[0] | (difference(1) & 0xfffff) << 32 | edge;
      word[1] = difference(2) | difference(3) << 26 | difference(1) >> 20 << 52 | lanes;
      return;
    }
    word[0] = named[0] | difference(1) << 26 | (difference(3) & 0xff) << 44 | edge;
    word[1] = difference(2) | difference(3) >> 8 << 18 | std::uint64_t{of_placement} << 28 | lanes |
              kOne << 63;
  }
  /// Sets edge_max, rounded up. Precondition: `edge` is not negative and not NaN.
  void set_edge_max(float edge) {
    const std::uint64_t upper = (std::bit_cast<std::uint32_t>(edge) + 0x7ffffu) >> 19;
    word[0] = (word[0] << 12 >> 12) | upper << 52;
  }

 private:
  static constexpr std::uint64_t kCapacityBits = std::uint64_t{3} << 58;
  /// 1 if capacity() is 8 or 12, else 0.
  std::uint32_t is_larger() const { return bits(1, 58, 1); }
  bool is_behind() const { return word[1] >> 63 != 0; }
  std::uint32_t bits(std::size_t i, std::size_t from, std::uint32_t count) const {
    return static_cast<std::uint32_t>(word[i] >> from & ((std::uint64_t{1} << count) - 1));
  }
};
static_assert(sizeof(LeafBlock) == 32);

}  // namespace sightline
