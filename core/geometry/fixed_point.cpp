#include "core/geometry/fixed_point.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/geometry/float64_parts.h"

namespace sightline {

namespace {

__extension__ using UInt128 = unsigned __int128;

using FixedVector = std::array<std::int64_t, 3>;
using WideVector = std::array<Int128, 3>;

/// The grid of the multiples of 2^exponent, on which the largest of some numbers lies in [2^59, 2^60).
class Grid {
 public:
  explicit Grid(double largest) {
    if (!(largest > 0)) return;  // all are zero, on every grid
    const Float64Parts parts(largest);
    exponent_ = parts.place + 63 - std::countl_zero(parts.mantissa) - 59;
    // Both powers of two, and every multiple below 2^60, are normal float64 numbers.
    is_exact_ = exponent_ >= -960 && exponent_ <= 960;
    if (is_exact_) unit_ = power(exponent_), scale_ = power(-exponent_);
  }
  int exponent() const { return exponent_; }
  /// Whether all numbers so far were multiples.
  bool is_exact() const { return is_exact_; }
  std::int64_t operator()(double value) {
    if (!is_exact_) return 0;
    const auto multiple = static_cast<std::int64_t>(value * scale_);
    is_exact_ = static_cast<double>(multiple) * unit_ == value;
    return multiple;
  }
  FixedVector operator()(const Vec3d& v) { return {(*this)(v.x), (*this)(v.y), (*this)(v.z)}; }

 private:
  /// 2^exponent, a normal number.
  static double power(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
  }
  int exponent_ = 0;
  bool is_exact_ = true;
  double unit_ = 1, scale_ = 1;
};

double largest_of(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

FixedVector fixed_difference(const FixedVector& a, const FixedVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Components below 2^61 give products below 2^122 and their difference below 2^123.
WideVector fixed_cross(const FixedVector& a, const FixedVector& b) {
  return {Int128{a[1]} * b[2] - Int128{a[2]} * b[1], Int128{a[2]} * b[0] - Int128{a[0]} * b[2],
          Int128{a[0]} * b[1] - Int128{a[1]} * b[0]};
}

/// The halves of a (64 bits unsigned, 59 bits signed) times b (61 bits) are summed apart. Three products are below 2^127.
Int256 fixed_dot(const WideVector& a, const FixedVector& b) {
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
  Grid space(std::max({largest_of(origin), largest_of(triangle.v0), largest_of(triangle.v1),
                       largest_of(triangle.v2)}));
  Grid directions(largest_of(direction));
  const FixedVector o = space(origin), d = directions(direction);
  const FixedVector a = fixed_difference(space(triangle.v0), o);
  const FixedVector b = fixed_difference(space(triangle.v1), o);
  const FixedVector c = fixed_difference(space(triangle.v2), o);
  if (!space.is_exact() || !directions.is_exact()) return std::nullopt;

  FixedHit hit;
  hit.space_exponent = space.exponent();
  hit.direction_exponent = directions.exponent();
  const WideVector bc = fixed_cross(b, c);
  hit.w0 = fixed_dot(bc, d);
  hit.w1 = fixed_dot(fixed_cross(c, a), d);
  hit.w2 = fixed_dot(fixed_cross(a, b), d);
  hit.numerator = fixed_dot(bc, a);
  return hit;
}

}  // namespace sightline
