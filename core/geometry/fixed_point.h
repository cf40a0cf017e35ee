#pragma once
/// The fast stage of the exact predicate ray against triangle: all coordinates as integers on a
/// common grid.
///
/// This stage applies if the twelve coordinates of the origin and the corners fit one grid, and
/// those of the direction another. They fit if they are multiples of one power of two between
/// 2^-960 and 2^960, and less than 2^60 times that power. All float32 scenes of ordinary extent
/// satisfy that, and nearly all float64 rays into them. Then cross products of two differences fit
/// 128 bits, and determinants fit 256 bits. Nothing is rounded, so the proof is a count of bits.
/// Dyadic numbers decide all other input (exact_hit.h).

#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/triangle.h"

namespace sightline {

__extension__ using Int128 = __int128;

/// A signed integer of 256 bits in two's complement; limb[0] has the lowest bits.
struct Int256 {
  std::array<std::uint64_t, 4> limb{};

  /// The sign of the number: -1, 0 or 1.
  int sign() const {
    if ((limb[3] >> 63) != 0) return -1;
    return (limb[0] | limb[1] | limb[2] | limb[3]) != 0 ? 1 : 0;
  }
  /// a + b and -a, modulo 2^256.
  friend Int256 operator+(const Int256& a, const Int256& b);
  Int256 operator-() const;
};

/// Three coordinates as multiples of the unit of a grid, below 2^61 in magnitude.
using FixedVector = std::array<std::int64_t, 3>;

/// The numbers w0, w1, w2 and the numerator of t for a line and a triangle, as exact_hit.h defines
/// them. The value of each is its integer times the unit that its comment states.
struct FixedHit {
  FixedVector a, b, c;  ///< the corners minus the origin; unit 2^space_exponent
  FixedVector d;        ///< the direction; unit 2^direction_exponent
  Int256 w0, w1, w2;    ///< unit 2^(2 * space_exponent + direction_exponent)
  Int256 numerator;     ///< A.(B x C); unit 2^(3 * space_exponent)
  /// Coordinates of points are multiples of 2^space_exponent, those of the direction multiples of
  /// 2^direction_exponent.
  int space_exponent = 0;
  int direction_exponent = 0;
};

/// Computes these numbers. Empty if the coordinates do not fit their grids. Preconditions: all
/// numbers are finite, direction is not zero.
std::optional<FixedHit> fixed_hit(const Vec3d& origin, const Vec3d& direction,
                                  const Triangle& triangle);

/// A ray parameter t = numerator / denominator * 2^exponent.
struct FixedT {
  Int256 numerator, denominator;
  int exponent = 0;
};

/// A point where a line in the plane of a triangle meets the border of the triangle.
struct FixedCrossing {
  FixedT t;
  std::uint32_t corners = 0;  ///< bit i: corner i; one for a corner, two for the ends of an edge
};

/// The ratio with an error of at most 2^-50 of itself or 2^-1074, whichever is more. Infinite beyond
/// the largest float64. Precondition: the denominator is not zero. Cost: some nanoseconds.
double approximate_quotient(const FixedT& t);

/// The ratio rounded once to the nearest float64, ties to even; an exact zero is +0. Empty where 60
/// bits of it do not tell, and for subnormal and infinite results. Precondition: the denominator is
/// not zero. Cost: some ten nanoseconds.
std::optional<double> certain_rounding(const FixedT& t);

/// Finds where a line in the plane of a triangle meets the border of the triangle, at most twice.
/// Writes these points to `at`, in any order, and returns their number. 0: the line misses the
/// triangle, or the triangle has no area. Precondition: w0, w1 and w2 are 0.
std::size_t fixed_crossings(const FixedHit& hit, std::array<FixedCrossing, 2>& at);

}  // namespace sightline

// Tests: tests/unit/geometry/dyadic_test.cpp
