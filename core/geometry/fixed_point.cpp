#include "core/geometry/fixed_point.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/geometry/float64_parts.h"

namespace sightline {

namespace {

__extension__ using UInt128 = unsigned __int128;

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

/// low + 2^64 high.
Int256 joined(Int128 low, Int128 high) {
  high += low >> 64;
  const auto top = static_cast<std::uint64_t>(high >> 64);
  return {{static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(high), top,
           high < 0 ? ~std::uint64_t{0} : 0}};
}

/// The halves of a (64 bits unsigned, 59 bits signed) times b (61 bits).
Int256 fixed_product(Int128 a, std::int64_t b) {
  return joined(Int128{static_cast<std::uint64_t>(a)} * b,
                Int128{static_cast<std::int64_t>(a >> 64)} * b);
}

Int256 widened(std::int64_t a) {
  const std::uint64_t sign = a < 0 ? ~std::uint64_t{0} : 0;
  return {{static_cast<std::uint64_t>(a), sign, sign, sign}};
}

/// The halves as in fixed_product, summed apart. Three products are below 2^127.
Int256 fixed_dot(const WideVector& a, const FixedVector& b) {
  Int128 low = 0, high = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    low += Int128{static_cast<std::uint64_t>(a[i])} * b[i];
    high += Int128{static_cast<std::int64_t>(a[i] >> 64)} * b[i];
  }
  return joined(low, high);
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

namespace {

/// A magnitude from bits * 2^exponent to less than (bits + 1) * 2^exponent; bits is at least 2^63, or
/// 0 for 0.
struct Leading {
  std::uint64_t bits = 0;
  int exponent = 0;
};

Leading leading(const Int256& number) {
  const Int256 magnitude = number.sign() < 0 ? -number : number;
  std::size_t top = 3;
  while (top > 0 && magnitude.limb[top] == 0) --top;
  const std::uint64_t high = magnitude.limb[top], low = top > 0 ? magnitude.limb[top - 1] : 0;
  const int shift = std::countl_zero(high);
  if (shift == 64) return {};
  return {shift == 0 ? high : high << shift | low >> (64 - shift),
          64 * static_cast<int>(top) - shift};
}

bool is_negative(const FixedT& t) { return t.numerator.sign() * t.denominator.sign() < 0; }

}  // namespace

double approximate_quotient(const FixedT& t) {
  const Leading n = leading(t.numerator), d = leading(t.denominator);
  const double quotient = std::ldexp(static_cast<double>(n.bits) / static_cast<double>(d.bits),
                                     n.exponent - d.exponent + t.exponent);
  return is_negative(t) ? -quotient : quotient;
}

std::optional<double> certain_rounding(const FixedT& t) {
  const Leading n = leading(t.numerator), d = leading(t.denominator);
  if (n.bits == 0) return 0.0;
  // From 2^62 to 2^64. The true quotient of the magnitudes differs by less than quotient / d.bits + 1
  // below it and quotient / n.bits + 2 above it, which is less than 4.
  const auto quotient = static_cast<std::uint64_t>((UInt128{n.bits} << 63) / d.bits);
  constexpr std::uint64_t kError = 4;
  const int shift = 64 - 53 - std::countl_zero(quotient);
  const std::uint64_t half = std::uint64_t{1} << (shift - 1), rest = quotient & (2 * half - 1);
  if (rest + kError >= half && rest <= half + kError) return std::nullopt;
  const std::uint64_t rounded = (quotient >> shift) + (rest > half ? 1 : 0);
  const int exponent = shift - 63 + n.exponent - d.exponent + t.exponent;
  if (exponent < -1022 || exponent > 900) return std::nullopt;
  const double magnitude = std::ldexp(static_cast<double>(rounded), exponent);
  return is_negative(t) ? -magnitude : magnitude;
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

  const WideVector bc = fixed_cross(b, c);
  return FixedHit{a,
                  b,
                  c,
                  d,
                  fixed_dot(bc, d),
                  fixed_dot(fixed_cross(c, a), d),
                  fixed_dot(fixed_cross(a, b), d),
                  fixed_dot(bc, a),
                  space.exponent(),
                  directions.exponent()};
}

std::size_t fixed_crossings(const FixedHit& hit, std::array<FixedCrossing, 2>& at) {
  const FixedVector& d = hit.d;
  const std::array<const FixedVector*, 3> corner{&hit.a, &hit.b, &hit.c};
  // Edges are below 2^61.
  const WideVector n = fixed_cross(fixed_difference(hit.b, hit.a), fixed_difference(hit.c, hit.a));
  // Projects along an axis for which the area is not zero; nor is the direction's component there.
  std::size_t k = 0;
  while (k < 3 && n[k] == 0) ++k;
  if (k == 3) return 0;
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3, m = d[i] != 0 ? i : j;

  // side: on which side of the line each corner lies; below 2^122.
  std::array<Int128, 3> side;
  for (std::size_t c = 0; c < 3; ++c)
    side[c] = Int128{d[i]} * (*corner[c])[j] - Int128{d[j]} * (*corner[c])[i];

  // A corner on the line, or an edge whose ends lie strictly on different sides. The corners do not
  // all lie on the line, so there are at most two of these.
  std::size_t count = 0;
  const int exponent = hit.space_exponent - hit.direction_exponent;
  for (std::size_t p = 0; p < 3; ++p) {
    const std::size_t q = (p + 1) % 3;
    const std::int64_t at_p = (*corner[p])[m], at_q = (*corner[q])[m];
    if (side[p] == 0) {
      at[count++] = {{widened(at_p), widened(d[m]), exponent}, 1u << p};
    } else if (side[q] != 0 && (side[p] < 0) != (side[q] < 0)) {
      at[count++] = {{fixed_product(side[p], at_q) + -fixed_product(side[q], at_p),
                      fixed_product(side[p] - side[q], d[m]), exponent},
                     1u << p | 1u << q};
    }
  }
  return count;
}

}  // namespace sightline
