#pragma once
/// Exact numbers for the oracle: num / den * 2^shift with GMP integers. Kept apart from mpq_class
/// because a common power of two carries the magnitude (1e-324 to 1e308), so that no gcd and no
/// thousand-bit shift is paid for on the way. Shares no code with core/geometry or core/trace.

#include <gmpxx.h>

namespace sightline::oracle {

/// The value num / den * 2^shift. Law: den > 0. Not reduced.
struct Rational {
  mpz_class num = 0;
  mpz_class den = 1;
  long shift = 0;

  int sign() const { return sgn(num); }
};

/// Precondition: value is finite. value = mantissa * 2^exponent exactly, |mantissa| < 2^53;
/// mantissa 0 has exponent 0.
struct Binary {
  long long mantissa = 0;
  int exponent = 0;
};
Binary split(double value);

/// The same number. Precondition: finite.
Rational exact(double value);
mpq_class to_mpq(const Rational& value);

/// -1, 0 or 1.
int compare(const Rational& a, const Rational& b);
/// Precondition: b is not NaN. Infinities compare as one expects.
int compare(const Rational& a, double b);

/// The float64 nearest to the value, ties to even, as IEEE 754 roundTiesToEven does it: denormals
/// are rounded once (no double rounding), a magnitude of (2 - 2^-53) * 2^1023 or more becomes
/// infinity. Exactly zero is +0; a negative value that rounds to zero is -0.
double round_to_double(const Rational& value);

/// The distance of neighbouring float64 numbers in the binade that holds value: 2^k with
/// k = max(floor(log2 |value|) - 52, -1074). For zero k is -1074.
long ulp_exponent(const mpq_class& value);

}  // namespace sightline::oracle
