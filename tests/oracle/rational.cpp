#include "tests/oracle/rational.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::oracle {
namespace {

/// Number of bits of |value|; 0 for 0.
long bit_length(const mpz_class& value) {
  return sgn(value) == 0 ? 0 : static_cast<long>(mpz_sizeinbase(value.get_mpz_t(), 2));
}

mpz_class shifted_left(const mpz_class& value, long bits) {
  return value << static_cast<mp_bitcnt_t>(bits);
}

/// floor(log2(num / den)) for positive num and den.
long floor_log2(const mpz_class& num, const mpz_class& den) {
  long log = bit_length(num) - bit_length(den);  // the quotient lies in (2^(log-1), 2^(log+1))
  const mpz_class left = log < 0 ? shifted_left(num, -log) : num;
  const mpz_class right = log > 0 ? shifted_left(den, log) : den;
  return left < right ? log - 1 : log;
}

constexpr long kMinExponent = -1074;
constexpr long kMaxExponent = 1024;

}  // namespace

Binary split(double value) {
  if (value == 0) return {};
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  return {static_cast<long long>(std::ldexp(fraction, 53)), exponent - 53};
}

Rational exact(double value) {
  const Binary parts = split(value);
  return {mpz_class(static_cast<long>(parts.mantissa)), 1, parts.exponent};
}

mpq_class to_mpq(const Rational& value) {
  mpq_class result = value.shift >= 0 ? mpq_class(shifted_left(value.num, value.shift), value.den)
                                      : mpq_class(value.num, shifted_left(value.den, -value.shift));
  result.canonicalize();
  return result;
}

int compare(const Rational& a, const Rational& b) {
  if (a.sign() != b.sign()) return a.sign() < b.sign() ? -1 : 1;
  mpz_class left = a.num * b.den;
  mpz_class right = b.num * a.den;
  if (a.shift > b.shift) left <<= static_cast<mp_bitcnt_t>(a.shift - b.shift);
  if (b.shift > a.shift) right <<= static_cast<mp_bitcnt_t>(b.shift - a.shift);
  const int order = cmp(left, right);
  return order < 0 ? -1 : order > 0 ? 1 : 0;
}

int compare(const Rational& a, double b) {
  if (std::isinf(b)) return b > 0 ? -1 : 1;
  return compare(a, exact(b));
}

double round_to_double(const Rational& value) {
  if (value.sign() == 0) return 0.0;
  const bool negative = value.sign() < 0;
  const mpz_class magnitude = abs(value.num);

  // The last place that the result may have: 53 bits, or fewer among the denormals.
  const long log = floor_log2(magnitude, value.den) + value.shift;
  if (log >= kMaxExponent) {
    return negative ? -std::numeric_limits<double>::infinity()
                    : std::numeric_limits<double>::infinity();
  }
  const long last = std::max(log - 52, kMinExponent);

  // Quotient in units of the last place, rounded by the remainder. A value far below half the
  // smallest denormal needs no quotient.
  mpz_class quotient = 0;
  if (log >= kMinExponent - 1) {
    const long up = value.shift - last;
    const mpz_class num = up > 0 ? shifted_left(magnitude, up) : magnitude;
    const mpz_class den = up < 0 ? shifted_left(value.den, -up) : value.den;
    mpz_class remainder;
    mpz_fdiv_qr(quotient.get_mpz_t(), remainder.get_mpz_t(), num.get_mpz_t(), den.get_mpz_t());
    remainder <<= 1;
    const int half = cmp(remainder, den);
    if (half > 0 || (half == 0 && mpz_odd_p(quotient.get_mpz_t()) != 0)) ++quotient;
  }
  // At most 2^53, so both steps are exact; ldexp gives infinity for 2^53 * 2^971.
  const double result = std::ldexp(quotient.get_d(), static_cast<int>(last));
  return negative ? -result : result;
}

long ulp_exponent(const mpq_class& value) {
  if (sgn(value) == 0) return kMinExponent;
  return std::max(floor_log2(abs(value.get_num()), value.get_den()) - 52, kMinExponent);
}

}  // namespace sightline::oracle
