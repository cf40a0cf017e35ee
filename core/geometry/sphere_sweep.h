#pragma once
/// A sphere swept along a line, against a triangle, exactly.
///
/// Method   The centre first comes within the radius of the triangle at a corner, inside an edge or
///          inside the triangle. The time is the first root of a quadratic, or a quotient with one
///          root in it. Such numbers are compared by signs of polynomials, of degree 24 at most,
///          and rounded by comparison with float64 numbers.
/// Proofs   docs/explanation/exactness-sweeps.md.

#include <optional>
#include <variant>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/root.h"
#include "core/geometry/sweep_path.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points within this distance of the centre; finite, not negative.
struct SweptSphere {
  double radius = 0;
};

/// The first contact of a swept sphere with a triangle.
class SphereContact {
 public:
  /// Empty if they never meet within the limits, and for triangles that have exactly no area or a
  /// corner that is not finite.
  static std::optional<SphereContact> first(const SweepPath& path, const SweptSphere& sphere,
                                            const Triangle& triangle);

  /// t, rounded once.
  double rounded() const;
  /// Sign of a - b. They are of the same radius.
  friend int compare(const SphereContact& a, const SphereContact& b);
  /// The point of the triangle that is nearest to the centre at t, each coordinate rounded once.
  /// The same arguments as of first.
  Vec3d position(const SweepPath& path, const SweptSphere& sphere, const Triangle& triangle) const;

  /// The lesser root of a t^2 + 2 b t + c; a is positive, the discriminant not negative.
  struct Quadratic {
    Dyadic a, b, c;
  };
  /// (p - radius sqrt(square)) / rate; the rate is positive.
  struct OfPlane {
    Dyadic p, radius, square, rate;
    bool front = true;  ///< it comes from the counter-clockwise side
  };

 private:
  enum class Part { kCorner, kEdge, kInside };

  /// A limit, where the sphere has been in contact before.
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
