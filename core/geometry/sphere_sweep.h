#pragma once
/// A sphere swept along a line, against a triangle, exactly.
///
/// Method   The centre first comes within the radius of the triangle at a corner, at a point inside
///          of an edge, or at a point inside of the triangle. The time is the lesser root of a
///          quadratic, or a quotient with one square root in it. Such numbers are compared by signs
///          of polynomials of degree at most 24, and rounded by comparison with float64 numbers.
/// Proofs   docs/explanation/exactness-sweeps.md.

#include <optional>
#include <variant>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/root.h"
#include "core/geometry/sweep_path.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// A ball of this radius, in scene units, whose centre moves along a SweepPath. The radius is
/// finite and not negative.
struct SweptSphere {
  double radius = 0;
};

/// The first contact of a swept sphere with a triangle, as an exact number t. first() finds it,
/// compare() orders contacts of several triangles, rounded() and position() give its numbers.
class SphereContact {
 public:
  /// The contact with the least t in [tmin, tmax] of the path; touching is a contact. Empty if
  /// sphere and triangle never meet within these limits, if the triangle has exactly no area, or if
  /// a corner of the triangle is not finite. Preconditions: those of SweepPath and SweptSphere.
  static std::optional<SphereContact> first(const SweepPath& path, const SweptSphere& sphere,
                                            const Triangle& triangle);

  /// t rounded once to float64.
  double rounded() const;
  /// Sign of a.t - b.t, exactly: -1, 0 or 1. Precondition: both are contacts of spheres of equal
  /// radius.
  friend int compare(const SphereContact& a, const SphereContact& b);
  /// The point of the triangle that is nearest to the centre at t, each coordinate rounded once.
  /// Precondition: the arguments are those given to first().
  Vec3d position(const SweepPath& path, const SweptSphere& sphere, const Triangle& triangle) const;

  /// Internal: a time of contact with a corner or an edge, the lesser root of a t^2 + 2 b t + c. a
  /// is positive, the discriminant is not negative.
  struct Quadratic {
    Dyadic a, b, c;
  };
  /// Internal: a time of contact with the inside of the triangle, (p - radius sqrt(square)) / rate.
  /// The rate is positive.
  struct OfPlane {
    Dyadic p, radius, square, rate;
    /// the sphere comes from the side on which the corners run counter-clockwise
    bool front = true;
  };

 private:
  enum class Part { kCorner, kEdge, kInside };

  /// A contact at the limit t, for a sphere that touches the triangle there already.
  explicit SphereContact(double t) : t_(t) {}
  SphereContact(Part part, std::size_t at, Quadratic t) : part_(part), at_(at), t_(t) {}
  explicit SphereContact(OfPlane t) : part_(Part::kInside), t_(t) {}
  RootNumber value() const;
  int compare_to(const Dyadic& numerator, const Dyadic& divisor) const;

  Part part_ = Part::kInside;
  std::size_t at_ = 0;
  std::variant<double, Quadratic, OfPlane> t_;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
