#include "core/geometry/root.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sightline {

namespace {

double number_of(std::uint64_t bits) { return std::bit_cast<double>(bits); }

/// Half way from the float64 of these bits to the next one; above the largest float64 as if the
/// next number were 2^1024.
Dyadic midpoint_above(std::uint64_t bits) {
  const double below = number_of(bits), above = number_of(bits + 1);
  const double gap = std::isinf(above) ? std::ldexp(1.0, 971) : above - below;
  return Dyadic(below) + Dyadic(gap) * Dyadic(0.5);
}

}  // namespace

int sign_with_root(const Dyadic& a, const Dyadic& b, const Dyadic& c) {
  const int of_root = c.sign() == 0 ? 0 : b.sign();
  if (of_root == 0 || a.sign() == of_root) return a.sign();
  if (a.sign() == 0) return of_root;
  return a.sign() * compare(a * a, b * b * c);
}

double RootNumber::rounded() const {
  const int sign = compare_to(Dyadic());
  if (sign == 0) return 0;
  // Whether the magnitude is at least x.
  const auto reaches = [&](const Dyadic& x) { return sign * compare_to(sign > 0 ? x : -x) >= 0; };
  // A guess, then the bits of the largest float64 that is reached: by steps that double, so that a
  // bad guess costs a few comparisons and no more.
  double guess = approximate_quotient(a, divisor);
  if (b.sign() != 0) guess += approximate_quotient(b, divisor) * round_root(c, Dyadic(1.0));
  constexpr std::uint64_t kInfinite =
      std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity());
  guess = std::fabs(guess);
  std::uint64_t low = guess <= std::numeric_limits<double>::max()
                          ? std::bit_cast<std::uint64_t>(guess)
                          : kInfinite - 1;
  std::uint64_t high = low, step = 1;
  while (low > 0 && !reaches(Dyadic(number_of(low)))) {
    high = low;
    low -= std::min(low, step);
    step *= 2;
  }
  if (high == low) {
    for (high = low + 1; high < kInfinite && reaches(Dyadic(number_of(high))); step *= 2) {
      low = high;
      high = std::min(high + step, kInfinite);
    }
  }
  while (high - low > 1) {
    const std::uint64_t middle = low + (high - low) / 2;
    (reaches(Dyadic(number_of(middle))) ? low : high) = middle;
  }
  const Dyadic middle = midpoint_above(low);
  const int over = sign * compare_to(sign > 0 ? middle : -middle);
  const std::uint64_t nearest = over > 0 || (over == 0 && (low & 1) != 0) ? low + 1 : low;
  return sign * number_of(nearest);
}

}  // namespace sightline
