#pragma once
/// Dyadic: an exact number m * 2^e with an integer m of up to 73,728 bits. That is wide enough for
/// every determinant that the predicates form from float64 coordinates. Dyadic numbers decide what
/// the faster filters leave open.

#include <cstdint>

#include "core/geometry/fixed_point.h"

namespace sightline {

/// An exact number. Construct it from a float64, combine numbers with + - *, then ask for sign(),
/// compare() or a rounded quotient or root.
///
/// Stored as sign and magnitude. The magnitude is `count_` limbs of 64 bits; the lowest limb has
/// the weight 2^(64 * exponent_). The lowest and the highest limb are never zero, so equal values
/// have equal limbs.
///
/// Laws    +, -, * and comparisons are exact: no rounding, overflow or underflow. The width follows
///         from the inputs. A finite float64 spans the limbs -17 .. 15; a difference of two float64
///         numbers has at most 34 limbs with its carry. The widest number compares points that a
///         swept oriented box shares with a triangle: it sums products of 33 such differences,
///         1,122 limbs and carries. kCapacity is above that; results are not checked against it.
/// Cost    an object takes 9.2 KB. A constructor writes few limbs, a copy only those in use;
///         nothing allocates. Products take time proportional to the product of the limb counts.
class Dyadic {
 public:
  /// Most limbs of a number. Precondition of every operation: its result fits.
  static constexpr int kCapacity = 1152;

  /// Zero.
  Dyadic() = default;
  /// The value of a float64, exactly. Precondition: value is finite.
  explicit Dyadic(double value);
  Dyadic(const Dyadic& other) { copy(other); }
  Dyadic& operator=(const Dyadic& other) {
    if (this != &other) copy(other);
    return *this;
  }

  /// value * 2^exponent, exactly. Precondition: |exponent| < 10000.
  Dyadic(const Int256& value, int exponent);

  /// The sign of the number: -1, 0 or 1.
  int sign() const { return sign_; }
  Dyadic operator-() const {
    Dyadic result(*this);
    result.sign_ = -sign_;
    return result;
  }
  Dyadic abs() const { return sign_ < 0 ? -*this : *this; }

  friend Dyadic operator+(const Dyadic& a, const Dyadic& b) { return sum(a, b, b.sign_); }
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return sum(a, b, -b.sign_); }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);

  /// Sign of a - b: -1, 0 or 1.
  friend int compare(const Dyadic& a, const Dyadic& b);
  friend bool operator<(const Dyadic& a, const Dyadic& b) { return compare(a, b) < 0; }
  friend bool operator==(const Dyadic& a, const Dyadic& b) { return compare(a, b) == 0; }

  /// numerator / denominator, rounded once to the nearest float64, ties to even, as IEEE 754
  /// rounds: with gradual underflow (a negative quotient may become -0), and infinite beyond the
  /// largest number. An exact zero is +0. Precondition: denominator is not zero.
  friend double round_quotient(const Dyadic& numerator, const Dyadic& denominator);

  /// numerator / denominator with an error of at most 2^-50 of itself or 2^-1074, whichever is
  /// more. Faster than round_quotient, but not correctly rounded. Infinite beyond the largest
  /// float64. Precondition: denominator is not zero.
  friend double approximate_quotient(const Dyadic& numerator, const Dyadic& denominator);

  /// numerator / sqrt(square), of magnitude at most 1, rounded once to the nearest float64, ties to
  /// even. Preconditions: square is positive and at least numerator squared.
  friend double round_over_root(const Dyadic& numerator, const Dyadic& square);

  /// sqrt(numerator / denominator) rounded once to the nearest float64, ties to even; beyond the
  /// largest number an infinity. Preconditions: numerator not negative, denominator positive.
  friend double round_root(const Dyadic& numerator, const Dyadic& denominator);

 private:
  void copy(const Dyadic& other);
  void trim();
  static Dyadic sum(const Dyadic& a, const Dyadic& b, int b_sign);
  static int compare_magnitude(const Dyadic& a, const Dyadic& b);
  /// Returns the 64 leading bits as a float64 in [2^63, 2^64]; sets `exponent` to the exponent that
  /// belongs to them.
  double leading(int& exponent) const;
  /// sqrt(numerator / denominator) within some units in the last place; may overflow.
  static double approximate_root(const Dyadic& numerator, const Dyadic& denominator);

  int sign_ = 0;
  int exponent_ = 0;
  int count_ = 0;
  // only the first count_ limbs are initialised, so that a constructor is cheap
  std::uint64_t limb_[kCapacity];
};

}  // namespace sightline
