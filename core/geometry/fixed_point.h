#pragma once
/// The fast stage of the exact predicate ray against triangle: all coordinates as integers on a
/// common grid.
///
/// It applies if the twelve coordinates are multiples of one power of two, and less than 2^60 times
/// that power. All float32 scenes of ordinary extent satisfy that, and nearly all float64 rays into
/// them. Then cross products of two differences fit 128 bits, and determinants fit 256 bits.
/// Nothing is rounded, so the proof is a count of bits. Dyadic numbers decide all other input
/// (exact_hit.h).

#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/triangle.h"

namespace sightline {

__extension__ using Int128 = __int128;

/// A signed integer of 256 bits in two's complement; limb[0] has the lowest bits.
struct Int256 {
  std::array<std::uint64_t, 4> limb{};

  /// -1, 0 or 1.
  int sign() const {
    if ((limb[3] >> 63) != 0) return -1;
    return (limb[0] | limb[1] | limb[2] | limb[3]) != 0 ? 1 : 0;
  }
  friend Int256 operator+(const Int256& a, const Int256& b);
  Int256 operator-() const;
};

/// The signs w0, w1, w2 and the numerator of t for a line and a triangle, as exact_hit.h defines
/// them. Each is an integer times the unit beside it.
struct FixedHit {
  Int256 w0, w1, w2;  ///< unit 2^(2 * space_exponent + direction_exponent)
  Int256 numerator;   ///< A.(B x C); unit 2^(3 * space_exponent)
  /// The grid of coordinates has the unit 2^space_exponent, that of the direction
  /// 2^direction_exponent.
  int space_exponent = 0;
  int direction_exponent = 0;
};

/// Empty if the numbers do not fit the grid. Preconditions: all numbers are finite, direction is
/// not zero.
std::optional<FixedHit> fixed_hit(const Vec3d& origin, const Vec3d& direction,
                                  const Triangle& triangle);

}  // namespace sightline

// Tests: tests/unit/geometry/dyadic_test.cpp
