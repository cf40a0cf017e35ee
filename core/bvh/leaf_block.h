#pragma once
/// LeafBlock: a block of up to four triangles in a leaf of a tree, 160 bytes. A lane is the place
/// of one of these triangles, 0 to 3.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace sightline {

/// The lanes of a block.
inline constexpr int kLanes = 4;

/// Up to four triangles of one placement, as columns. Lanes from lane_count() on repeat lane 0 and
/// must be ignored. Builders write `corner`, then call set_names() and set_edge_max(). In a top
/// tree, lanes hold numbers of entries instead, and `corner` has no meaning.
///
/// After the corners, two words hold these fields, from their lowest bit on:
///     placement is 0   triangle[0] 32, difference[1] 20 low bits, edge_max 12
///                      difference[2] 26, difference[3] 26, difference[1] 6 high bits, zeros,
///                      lane_count 3, a zero
///     placement > 0    triangle[0] 26, difference[1] 18, difference[3] 8 low bits, edge_max 12
///                      difference[2] 18, difference[3] 10 high bits, placement 24, zeros,
///                      lane_count 3, a one
/// difference[i] is triangle[i] - triangle[0]. For placement 0 it has a sign; for others
/// triangle[0] is the smallest. edge_max holds the upper half of a float32 without its sign,
/// rounded up.
struct alignas(32) LeafBlock {
  /// Numbers of triangles of placements > 0 are below this; those of placement 0 have 32 bits.
  static constexpr std::uint64_t kTriangles = 1u << 26;
  static constexpr std::uint32_t kDifferences = 1u << 18;  ///< differences of placements > 0
  static constexpr std::uint32_t kNear = 1u << 25;         ///< |difference| of placement 0
  static constexpr std::uint32_t kPlacements = 1u << 24;   ///< numbers of placements are below this

  float corner[3][3][kLanes];  ///< [corner][axis][lane], mesh space, float32 as the file has it
  /// the packed fields
  std::uint64_t word[2];

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
  /// Sets the triangles' numbers, lane_count (`count`) and placement; edge_max is unchanged.
  /// named[i] repeats named[0] from `count` on. Preconditions: the numbers are below their limits,
  /// 1 <= count <= 4, fit() holds; if of_placement > 0, named[0] is the least number.
  void set_names(const std::array<std::uint32_t, kLanes>& named, std::uint32_t count,
                 std::uint32_t of_placement) {
    constexpr std::uint64_t kOne = 1;
    const auto difference = [&](std::size_t lane) {
      const std::uint32_t bits = (of_placement == 0 ? 2 * kNear : kDifferences) - 1;
      return std::uint64_t{(named[lane] - named[0]) & bits};
    };
    const std::uint64_t edge = word[0] >> 52 << 52;
    const std::uint64_t lanes = std::uint64_t{count} << 60;
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
  bool is_behind() const { return word[1] >> 63 != 0; }
  std::uint32_t bits(std::size_t i, std::size_t from, std::uint32_t count) const {
    return static_cast<std::uint32_t>(word[i] >> from & ((std::uint64_t{1} << count) - 1));
  }
};
static_assert(sizeof(LeafBlock) == 160);

}  // namespace sightline
