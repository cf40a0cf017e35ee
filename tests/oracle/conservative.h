#pragma once
/// What the oracle may skip without asking the integers. Every "no" here is certain, for every
/// float64 number from 2^-1074 to 2^1024: nothing below knows a scale or an epsilon.
///
/// Boxes: one operation of float64 rounds to a neighbour of the exact result, and an operation that
/// overflows rounds to an infinity whose neighbour is the largest number; so the result moved by
/// one number in either direction encloses the exact value, underflow and overflow included.
///
/// Triangles: long double has at least 64 bits and an exponent of 15 bits (x87 extended: 64 bits; binary128 of aarch64: 113). Differences of float64
/// numbers are zero or lie in [2^-1074, 2^1025], products of three in [2^-3222, 2^3075], quotients
/// of those in [2^-6300, 2^6300]; so nothing overflows or underflows, and every operation has a
/// relative error of at most 2^-64.

#include <limits>

#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

static_assert(std::numeric_limits<long double>::digits >= 64 &&
                  std::numeric_limits<long double>::max_exponent == 16384,
              "the oracle's culling is proved for at least 64 bits and an exponent of 15 bits");

struct Bounds {
  Vec3d min, max;
};

/// An interval of t that holds every exact t at which the line is in the closed box, cut to
/// [tmin, tmax]; low > high when there is none for certain.
struct Overlap {
  double low, high;
  bool empty() const { return low > high; }
};
/// Precondition: the bounds are finite.
Overlap overlap(const Ray& ray, const Bounds& bounds, double tmax);

/// False only if the ray certainly does not meet the triangle at a t in [ray.tmin, tmax].
bool may_meet(const Ray& ray, const Triangle& triangle, double tmax);

/// True only if the triangle certainly has an area.
bool certainly_has_area(const Triangle& triangle);

/// The neighbours of a float64 number; an infinity is its own neighbour on the far side.
double next_up(double value);
double next_down(double value);

}  // namespace sightline::oracle
