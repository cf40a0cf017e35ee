#pragma once
/// What the vector code for rays and boxes reads and writes: blocks of pairs as columns, and codes
/// of answers.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/geometry/ray_box.h"

namespace sightline {

/// Pairs in a block: they fill the vectors of every instruction set.
inline constexpr std::size_t kBlockPairs = 64;

/// A block of rays and boxes: pair i is ray i and box i.
struct PairColumns {
  alignas(64) double origin[3][kBlockPairs], direction[3][kBlockPairs], tmin[kBlockPairs],
      tmax[kBlockPairs];
  alignas(64) double lower[3][kBlockPairs], upper[3][kBlockPairs];
};

/// Where the line of each pair crosses one plane: t = (plane - origin) / direction, in float64.
/// All zeros but the direction: no crossing is asked for.
struct Crossings {
  alignas(64) double t[kBlockPairs], plane[kBlockPairs], origin[kBlockPairs],
      direction[kBlockPairs];
};

/// The answers of a block; code[i] is composed as pair_code says.
struct PairAnswers {
  alignas(64) double t[kBlockPairs], t_enter[kBlockPairs], t_exit[kBlockPairs];
  alignas(64) std::uint64_t code[kBlockPairs];
};

/// The code of an answer: the fields of RayBoxAnswer in one word, and the list of faces that a code
/// stands for.
namespace pair_code {

inline constexpr std::uint64_t kOutcome = 7;  ///< mask of the RayBoxOutcome
/// Shifts of two bits: the axis entered last, and the axis left first.
inline constexpr int kEnterAxis = 3, kExitAxis = 5;
/// Shifts of a bit.
inline constexpr int kInside = 7, kOnSurface = 8;
/// Shift of a bit: t is that of the exit, and faces through which the ray leaves are listed first.
/// The ten bits from here on determine the faces that the ray crosses.
inline constexpr int kLeaving = 9;
/// Shifts of three bits, one per axis: faces at t.
inline constexpr int kNearFaces = 10, kFarFaces = 13;
/// Shift of three bits: the ray passes the lower plane first.
inline constexpr int kLowerFirst = 16;
/// Shift of two bits per axis, lower plane first: faces in whose planes the ray runs.
inline constexpr int kAlong = 19;

/// RayBoxAnswer::faces for each value of the ten bits of a code from kLeaving on: 13 KiB. A loop
/// over the axes of each answer takes a third of the time of a pair.
inline constexpr std::array<BoxFaces, 1024> kFaces = [] {
  std::array<BoxFaces, 1024> lists{};
  for (std::uint64_t i = 0; i < lists.size(); ++i) {
    const std::uint64_t code = i << kLeaving;
    const bool leaving = (code >> kLeaving & 1) != 0;
    const std::uint64_t lower_first = code >> kLowerFirst & 7;
    for (const bool far : {leaving, !leaving}) {
      const std::uint64_t upper = far ? lower_first : ~lower_first;
      for (std::uint64_t axes = code >> (far ? kFarFaces : kNearFaces) & 7; axes != 0;
           axes &= axes - 1) {
        const int k = std::countr_zero(axes);
        lists[i].add({static_cast<std::uint8_t>(k), (upper >> k & 1) != 0});
      }
    }
  }
  return lists;
}();

/// RayBoxAnswer::apart for each value of the lower seven bits of a code.
inline constexpr std::array<std::array<std::uint8_t, 2>, 128> kApart = [] {
  std::array<std::array<std::uint8_t, 2>, 128> axes{};
  for (std::uint64_t code = 0; code < axes.size(); ++code) {
    const auto outcome = static_cast<RayBoxOutcome>(code & kOutcome);
    if (outcome != RayBoxOutcome::kApart && outcome != RayBoxOutcome::kBeside) continue;
    const auto a = static_cast<std::uint8_t>(code >> kEnterAxis & 3);
    const auto b = static_cast<std::uint8_t>(code >> kExitAxis & 3);
    axes[code] = {std::min(a, b), std::max(a, b)};
  }
  return axes;
}();

}  // namespace pair_code
}  // namespace sightline

// Tests: tests/unit/run/boxes_test.cpp
