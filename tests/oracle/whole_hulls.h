#pragma once
/// The judge of convex hulls of points with whole coordinates, by separating axes in integers. It
/// finds no faces: every cross product of two differences of points is tried.

#include <array>
#include <vector>

#include "core/geometry/vec3.h"
#include "tests/oracle/random.h"

namespace sightline::oracle {

/// A point or a vector. Products of the functions below fit if coordinates are below 2^8.
using Whole = std::array<long long, 3>;

inline Whole minus(const Whole& a, const Whole& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline long long dot(const Whole& a, const Whole& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// A random point with |coordinate| <= size.
Whole whole_point(Random& random, int size);
/// The float64 point p * 2^exponent. Precondition: it is exact.
Vec3d scaled(const Whole& p, int exponent);

enum class Meeting {
  kApart,
  kTouch,    ///< they meet, and arbitrarily short translations separate them
  kOverlap,  ///< they meet, and no short translation separates them
};
/// How the convex hulls of two sets of points lie to each other.
Meeting meeting_of(const std::vector<Whole>& a, const std::vector<Whole>& b);

/// The shortest translation of a set of points, whose hull meets a triangle, after which the hulls
/// have no common point but on their border: along / |along| * (overlap / |along|). Of several the
/// one along the triangle's normal, else along its reverse, else the one whose unit vector has the
/// largest x, then y, then z. If the overlap is 0, cross products of differences of points that are
/// no edges count too.
struct LeastTranslation {
  long long overlap = 0;
  Whole along{};
};
LeastTranslation least_translation(const std::vector<Whole>& points,
                                   const std::array<Whole, 3>& triangle);

}  // namespace sightline::oracle
