#pragma once
/// The fast stage of the exact predicate: ray and triangle as integers on a common grid.
///
/// It applies to twelve coordinates that are multiples of one power of two, and less than 2^60 times
/// that power. All float32 scenes of ordinary extent satisfy that, and nearly all float64 rays into
/// them. Cross products of two differences then fit 128 bits, and determinants 256. Nothing is
/// rounded, so the only proof is a count of bits. Other input is decided by Dyadic.

#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/triangle.h"

namespace sightline {

__extension__ using Int128 = __int128;

/// Two's complement, lowest limb first.
struct Int256 {
  std::array<std::uint64_t, 4> limb{};

  int sign() const {
    if ((limb[3] >> 63) != 0) return -1;
    return (limb[0] | limb[1] | limb[2] | limb[3]) != 0 ? 1 : 0;
  }
  friend Int256 operator+(const Int256& a, const Int256& b);
  Int256 operator-() const;
};

/// Signs and t of a line and a triangle, all as integers of one unit each.
struct FixedHit {
  Int256 w0, w1, w2;  ///< exact_hit.h; unit 2^(2 * space_exponent + direction_exponent)
  Int256 numerator;   ///< A.(B x C); unit 2^(3 * space_exponent)
  int space_exponent = 0;
  int direction_exponent = 0;
};

/// Empty if the numbers do not fit the grid. Preconditions: everything finite, direction not zero.
std::optional<FixedHit> fixed_hit(const Vec3d& origin, const Vec3d& direction,
                                  const Triangle& triangle);

}  // namespace sightline

// Tests: tests/unit/geometry/dyadic_test.cpp
