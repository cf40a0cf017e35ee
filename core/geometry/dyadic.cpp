#include "core/geometry/dyadic.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/geometry/float64_parts.h"

namespace sightline {

namespace {
__extension__ using Wide = unsigned __int128;
}

// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): limbs beyond count_ are never read
Dyadic::Dyadic(double value) {
  const Float64Parts parts(value);
  if (parts.mantissa == 0) return;
  // Limb numbers are floor(place / 64).
  const int shift = parts.place & 63;
  sign_ = parts.negative ? -1 : 1;
  exponent_ = parts.place >> 6;
  limb_[0] = parts.mantissa << shift;
  limb_[1] = shift == 0 ? 0 : parts.mantissa >> (64 - shift);
  count_ = 2;
  trim();
}

// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
Dyadic::Dyadic(const Int256& value, int exponent) {
  sign_ = value.sign();
  if (sign_ == 0) return;
  const Int256 magnitude = sign_ < 0 ? -value : value;
  exponent_ = exponent >> 6;
  const int shift = exponent & 63;
  std::uint64_t carried = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    limb_[i] = shift == 0 ? magnitude.limb[i] : (magnitude.limb[i] << shift) | carried;
    carried = shift == 0 ? 0 : magnitude.limb[i] >> (64 - shift);
  }
  limb_[4] = carried;
  count_ = 5;
  trim();
}

void Dyadic::copy(const Dyadic& other) {
  sign_ = other.sign_;
  exponent_ = other.exponent_;
  count_ = other.count_;
  std::memcpy(limb_, other.limb_, static_cast<std::size_t>(count_) * sizeof(limb_[0]));
}

void Dyadic::trim() {
  while (count_ > 0 && limb_[count_ - 1] == 0) --count_;
  int zeros = 0;
  while (zeros < count_ && limb_[zeros] == 0) ++zeros;
  if (zeros > 0) {
    count_ -= zeros;
    exponent_ += zeros;
    std::memmove(limb_, limb_ + zeros, static_cast<std::size_t>(count_) * sizeof(limb_[0]));
  }
  if (count_ == 0) sign_ = exponent_ = 0;
}

int Dyadic::compare_magnitude(const Dyadic& a, const Dyadic& b) {
  const int a_top = a.exponent_ + a.count_;
  const int b_top = b.exponent_ + b.count_;
  if (a_top != b_top) return a_top < b_top ? -1 : 1;
  // Both tops are non-zero limbs of the same weight: compare downwards, then by what is left.
  const int shared = a.count_ < b.count_ ? a.count_ : b.count_;
  for (int i = 1; i <= shared; ++i) {
    const std::uint64_t x = a.limb_[a.count_ - i];
    const std::uint64_t y = b.limb_[b.count_ - i];
    if (x != y) return x < y ? -1 : 1;
  }
  return a.count_ == b.count_ ? 0 : a.count_ < b.count_ ? -1 : 1;
}

int compare(const Dyadic& a, const Dyadic& b) {
  if (a.sign_ != b.sign_) return a.sign_ < b.sign_ ? -1 : 1;
  if (a.sign_ == 0) return 0;
  return a.sign_ * Dyadic::compare_magnitude(a, b);
}

Dyadic Dyadic::sum(const Dyadic& a, const Dyadic& b, int b_sign) {
  if (b_sign == 0) return a;
  if (a.sign_ == 0) {
    Dyadic result(b);
    result.sign_ = b_sign;
    return result;
  }
  const bool add = a.sign_ == b_sign;
  const int order = add ? 1 : compare_magnitude(a, b);
  if (order == 0) return {};
  const Dyadic& large = order > 0 ? a : b;
  const Dyadic& small = order > 0 ? b : a;

  Dyadic result;
  result.sign_ = order > 0 ? a.sign_ : b_sign;
  result.exponent_ = a.exponent_ < b.exponent_ ? a.exponent_ : b.exponent_;
  const int a_top = a.exponent_ + a.count_;
  const int b_top = b.exponent_ + b.count_;
  const int top = a_top > b_top ? a_top : b_top;
  const int count = top - result.exponent_;
  const auto limb_of = [](const Dyadic& x, int place) -> std::uint64_t {
    const int i = place - x.exponent_;
    return i >= 0 && i < x.count_ ? x.limb_[i] : 0;
  };
  // One pass from the lowest limb up, with a carry or a borrow of 0 or 1.
  std::uint64_t carry = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t x = limb_of(large, result.exponent_ + i);
    const std::uint64_t y = limb_of(small, result.exponent_ + i);
    if (add) {
      const Wide s = Wide{x} + y + carry;
      result.limb_[i] = static_cast<std::uint64_t>(s);
      carry = static_cast<std::uint64_t>(s >> 64);
    } else {
      const Wide s = Wide{x} - y - carry;
      result.limb_[i] = static_cast<std::uint64_t>(s);
      carry = static_cast<std::uint64_t>(s >> 64) & 1;
    }
  }
  result.count_ = count;
  if (add && carry != 0) result.limb_[result.count_++] = carry;
  result.trim();
  return result;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  Dyadic result;
  if (a.sign_ == 0 || b.sign_ == 0) return result;
  result.sign_ = a.sign_ * b.sign_;
  result.exponent_ = a.exponent_ + b.exponent_;
  result.count_ = a.count_ + b.count_;
  std::memset(result.limb_, 0, static_cast<std::size_t>(result.count_) * sizeof(result.limb_[0]));
  for (int i = 0; i < a.count_; ++i) {
    std::uint64_t carry = 0;
    for (int k = 0; k < b.count_; ++k) {
      const Wide p = Wide{a.limb_[i]} * b.limb_[k] + result.limb_[i + k] + carry;
      result.limb_[i + k] = static_cast<std::uint64_t>(p);
      carry = static_cast<std::uint64_t>(p >> 64);
    }
    result.limb_[i + b.count_] = carry;
  }
  result.trim();
  return result;
}

double Dyadic::leading(int& exponent) const {
  const std::uint64_t high = limb_[count_ - 1];
  const std::uint64_t low = count_ > 1 ? limb_[count_ - 2] : 0;
  const int shift = std::countl_zero(high);
  const std::uint64_t bits = shift == 0 ? high : (high << shift) | (low >> (64 - shift));
  exponent = 64 * (exponent_ + count_ - 1) - shift;
  return static_cast<double>(bits);
}

double approximate_quotient(const Dyadic& numerator, const Dyadic& denominator) {
  if (numerator.sign_ == 0) return 0.0;
  int n_exponent = 0;
  int d_exponent = 0;
  const double n = numerator.leading(n_exponent);
  const double d = denominator.leading(d_exponent);
  const double quotient = std::ldexp(n / d, n_exponent - d_exponent);
  return numerator.sign_ * denominator.sign_ < 0 ? -quotient : quotient;
}

namespace {

bool is_odd(double x) { return (std::bit_cast<std::uint64_t>(x) & 1) != 0; }

/// Moves `guess` (not negative, finite) to the float64 nearest to a positive number that is known
/// by comparison only: `order(x)` is the sign of the number minus x, for midpoints x of neighbours.
/// Ties go to even; above the largest float64 the gap continues as if the next number were 2^1024.
template <class Order>
double settle(double guess, Order order) {
  const Dyadic half(0.5);
  for (;;) {
    const double above = std::nextafter(guess, std::numeric_limits<double>::infinity());
    const double gap = std::isinf(above) ? std::ldexp(1.0, 971) : above - guess;
    const int over = order(Dyadic(guess) + Dyadic(gap) * half);
    if (over > 0 || (over == 0 && is_odd(guess))) {
      if (std::isinf(above)) return above;
      guess = above;
      continue;
    }
    if (guess == 0) return guess;
    const double below = std::nextafter(guess, 0.0);
    const int under = order(Dyadic(guess) - Dyadic(guess - below) * half);
    if (under > 0 || (under == 0 && !is_odd(guess))) return guess;
    guess = below;
  }
}

}  // namespace

double round_quotient(const Dyadic& numerator, const Dyadic& denominator) {
  if (numerator.sign() == 0) return 0.0;
  const Dyadic n = numerator.abs();
  const Dyadic d = denominator.abs();
  // A first guess from the leading 64 bits is within a few units in the last place.
  const double guess = std::min(approximate_quotient(n, d), std::numeric_limits<double>::max());
  const double rounded = settle(guess, [&](const Dyadic& x) { return compare(n, x * d); });
  return numerator.sign() * denominator.sign() < 0 ? -rounded : rounded;
}

double Dyadic::approximate_root(const Dyadic& numerator, const Dyadic& denominator) {
  // By halves of the exponent: a square may underflow where its root does not, and a guess must be
  // close, or finding the neighbour takes for ever.
  int n_exponent = 0;
  int d_exponent = 0;
  double ratio = numerator.leading(n_exponent) / denominator.leading(d_exponent);
  int exponent = n_exponent - d_exponent;
  if ((exponent & 1) != 0) {
    ratio *= 2;
    --exponent;
  }
  return std::ldexp(std::sqrt(ratio), exponent / 2);
}

double round_root(const Dyadic& numerator, const Dyadic& denominator) {
  if (numerator.sign() == 0) return 0.0;
  const double guess = std::min(Dyadic::approximate_root(numerator, denominator),
                                std::numeric_limits<double>::max());
  return settle(guess, [&](const Dyadic& x) { return compare(numerator, x * x * denominator); });
}

double round_over_root(const Dyadic& numerator, const Dyadic& square) {
  if (numerator.sign() == 0) return 0.0;
  const Dyadic n2 = numerator * numerator;
  const double guess = std::min(Dyadic::approximate_root(n2, square), 1.0);
  const double rounded =
      settle(guess, [&](const Dyadic& x) { return compare(n2, x * x * square); });
  return numerator.sign() < 0 ? -rounded : rounded;
}

}  // namespace sightline
