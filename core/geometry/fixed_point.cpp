#include "core/geometry/fixed_point.h"

#include <algorithm>
#include <bit>

#include "core/geometry/float64_parts.h"

namespace sightline {

namespace {

__extension__ using UInt128 = unsigned __int128;

/// value = mantissa * 2^place, mantissa odd; place and top (its leading bit's weight) of all of
/// them.
struct Range {
  int lowest = 1 << 20;
  int highest = -(1 << 20);

  void include(double value) {
    const Float64Parts parts(value);
    if (parts.mantissa == 0) return;
    lowest = std::min(lowest, parts.place + std::countr_zero(parts.mantissa));
    highest = std::max(highest, parts.place + 63 - std::countl_zero(parts.mantissa));
  }
  void include(const Vec3d& v) {
    include(v.x);
    include(v.y);
    include(v.z);
  }
  /// All values are less than 2^60 of the lowest's unit: their differences are below 2^61.
  bool fits() const { return highest - lowest < 60; }
};

std::int64_t on_grid(double value, int exponent) {
  const Float64Parts parts(value);
  if (parts.mantissa == 0) return 0;
  const int shift = parts.place - exponent;
  const auto magnitude =
      static_cast<std::int64_t>(shift >= 0 ? parts.mantissa << shift : parts.mantissa >> -shift);
  return parts.negative ? -magnitude : magnitude;
}

using Vector = std::array<std::int64_t, 3>;
using WideVector = std::array<Int128, 3>;

Vector on_grid(const Vec3d& v, int exponent) {
  return {on_grid(v.x, exponent), on_grid(v.y, exponent), on_grid(v.z, exponent)};
}

Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Components below 2^61 give products below 2^122 and their difference below 2^123.
WideVector cross(const Vector& a, const Vector& b) {
  return {Int128{a[1]} * b[2] - Int128{a[2]} * b[1], Int128{a[2]} * b[0] - Int128{a[0]} * b[2],
          Int128{a[0]} * b[1] - Int128{a[1]} * b[0]};
}

/// The halves of a (64 bits unsigned, 59 bits signed) times b (61 bits) are summed apart: three products are below 2^127.
Int256 dot(const WideVector& a, const Vector& b) {
  Int128 low = 0, high = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    low += Int128{static_cast<std::uint64_t>(a[i])} * b[i];
    high += Int128{static_cast<std::int64_t>(a[i] >> 64)} * b[i];
  }
  high += low >> 64;
  const auto top = static_cast<std::uint64_t>(high >> 64);
  return {{static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(high), top,
           high < 0 ? ~std::uint64_t{0} : 0}};
}

}  // namespace

Int256 operator+(const Int256& a, const Int256& b) {
  Int256 sum;
  UInt128 carry = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    carry += UInt128{a.limb[i]} + b.limb[i];
    sum.limb[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return sum;
}

Int256 Int256::operator-() const {
  Int256 result;
  UInt128 carry = 1;
  for (std::size_t i = 0; i < 4; ++i) {
    carry += UInt128{~limb[i]};
    result.limb[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return result;
}

std::optional<FixedHit> fixed_hit(const Vec3d& origin, const Vec3d& direction,
                                  const Triangle& triangle) {
  Range space;
  space.include(origin);
  space.include(triangle.v0);
  space.include(triangle.v1);
  space.include(triangle.v2);
  Range directions;
  directions.include(direction);
  if (!space.fits() || !directions.fits()) return std::nullopt;

  FixedHit hit;
  hit.space_exponent = space.lowest > space.highest ? 0 : space.lowest;
  hit.direction_exponent = directions.lowest;
  const Vector o = on_grid(origin, hit.space_exponent);
  const Vector d = on_grid(direction, hit.direction_exponent);
  const Vector a = minus(on_grid(triangle.v0, hit.space_exponent), o);
  const Vector b = minus(on_grid(triangle.v1, hit.space_exponent), o);
  const Vector c = minus(on_grid(triangle.v2, hit.space_exponent), o);
  const WideVector bc = cross(b, c);
  hit.w0 = dot(bc, d);
  hit.w1 = dot(cross(c, a), d);
  hit.w2 = dot(cross(a, b), d);
  hit.numerator = dot(bc, a);
  return hit;
}

}  // namespace sightline
