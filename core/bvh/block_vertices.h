#pragma once
/// BlockVertices: the vertices of the triangles of a leaf block, each once where they fit.

#include <array>
#include <cstdint>
#include <cstring>

#include "core/base/index_column.h"
#include "core/bvh/leaf_block.h"

namespace sightline {

/// The vertices of up to four triangles, and which of them are the corners, as a leaf block stores
/// them. Two corners have one vertex if they have the index in common. The place of a corner is
/// 4 corner + lane.
class BlockVertices {
 public:
  /// Collects the corners of the triangles of four lanes. `indices` are those of the mesh.
  /// Precondition: the triangles are of the mesh.
  BlockVertices(const IndexView& indices, const std::array<std::uint32_t, kLanes>& triangles) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto index = indices.corners(triangles[lane]);
      for (std::size_t c = 0; c < 3; ++c) index_[c * kLanes + lane] = index[c];
    }
    // Triangles without a list of indices share none, but two of them need no more than 6.
    if (!indices.listed().empty() || triangles[2] == triangles[0]) {
      share();
    } else {
      std::memcpy(first_.data(), kPlaces, sizeof kPlaces);
    }
  }

  /// LeafBlock::capacity for them.
  std::uint32_t capacity() const { return count_ <= 6 ? 6 : count_ <= 8 ? 8 : 12; }
  /// The index of a corner's vertex in the mesh.
  std::uint32_t index(std::size_t place) const { return index_[place]; }
  /// The first place with the vertex of this one. It is less than `place` only if corners share it.
  std::uint32_t first(std::size_t place) const { return first_[place]; }

 private:
  using Four = std::uint32_t __attribute__((vector_size(16)));
  static constexpr Four kPlaces[3] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}};

  /// Finds equal indices.
  void share() {
    // Vectors of g++ and clang (docs/decisions/0029): which are equal is not predictable.
    Four index[3];
    std::memcpy(index, index_.data(), sizeof index);
    Four first0 = kPlaces[0], first1 = kPlaces[1], first2 = kPlaces[2];
    for (std::uint32_t place = LeafBlock::kMostVertices; place-- > 0;) {
      const Four other = index_[place] - Four{}, here = place - Four{};
      first0 = index[0] == other ? here : first0;
      first1 = index[1] == other ? here : first1;
      first2 = index[2] == other ? here : first2;
    }
    // A lane of a comparison is -1 if it is true.
    const auto unique = (first0 == kPlaces[0]) + (first1 == kPlaces[1]) + (first2 == kPlaces[2]);
    count_ = static_cast<std::uint32_t>(-(unique[0] + unique[1] + unique[2] + unique[3]));
    const Four first[3] = {first0, first1, first2};
    std::memcpy(first_.data(), first, sizeof first);
  }

  std::uint32_t count_ = LeafBlock::kMostVertices;  ///< different vertices
  std::array<std::uint32_t, LeafBlock::kMostVertices> index_, first_;
};

}  // namespace sightline

// Tests: tests/unit/bvh/leaf_block_test.cpp
