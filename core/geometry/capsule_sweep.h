#pragma once
/// A sphere or capsule swept along a line, against a triangle, exactly.
///
/// Method   The triangle makes a prism when it moves by the vector from the capsule's second end to
///          its first one. The capsule meets the triangle while its first end is within the radius
///          of the prism. The end first comes so near at a corner of the prism, at a point inside of an
///          edge, or at a point inside of a face. The time is the lesser root of a quadratic, or a
///          quotient with one square root in it. Such numbers are compared by signs of polynomials
///          of degree at most 24, and rounded by comparison with float64 numbers. The prism of a
///          sphere is T itself.
/// Proofs   docs/explanation/exactness-sweeps.md.

#include <optional>
#include <variant>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/root.h"
#include "core/geometry/sweep_path.h"
#include "core/geometry/triangle.h"

namespace sightline {

/// The points within `radius` of a segment. Its first end moves along a SweepPath; its second end
/// moves along with it, and is at `to` for t = 0. If `to` is the path's origin, the shape is a
/// sphere. Scene units; finite, and the radius is not negative.
struct SweptCapsule {
  Vec3d to;
  double radius = 0;
};

/// The first contact of a swept capsule with a triangle, as an exact number t. first() finds it,
/// compare() orders contacts of several triangles, rounded(), position() and normal() give its
/// numbers.
class CapsuleContact {
 public:
  /// The contact with the least t in [tmin, tmax] of the path; touching is a contact. Empty if
  /// capsule and triangle never meet within these limits, if the triangle has exactly no area, or
  /// if a corner of the triangle is not finite. Preconditions: those of SweepPath and SweptCapsule.
  static std::optional<CapsuleContact> first(const SweepPath& path, const SweptCapsule& capsule,
                                             const Triangle& triangle);

  /// t rounded once to float64.
  double rounded() const;
  /// Sign of a.t - b.t, exactly: -1, 0 or 1. Precondition: both are contacts of capsules of equal
  /// radius.
  friend int compare(const CapsuleContact& a, const CapsuleContact& b);
  /// A point of the triangle that is nearest to the capsule's segment at t, each coordinate rounded
  /// once. Of a capsule that met the triangle before tmin it is that for a segment whose ends at
  /// tmin are rounded to float64. Precondition: the arguments are those given to first().
  Vec3d position(const SweepPath& path, const SweptCapsule& capsule,
                 const Triangle& triangle) const;
  /// The unit vector from the position to the nearest point of the segment at t, each component
  /// rounded once. For a radius of 0 it is the normal of the face of the prism that is met, against
  /// the motion. Empty if the capsule met the triangle before tmin, and if its radius is 0 and no face
  /// is met but in its plane. Precondition: the arguments are those given to first().
  std::optional<Vec3d> normal(const SweepPath& path, const SweptCapsule& capsule,
                              const Triangle& triangle) const;

  /// Internal: a time of contact with a corner or an edge, the lesser root of a t^2 + 2 b t + c. a
  /// is positive, the discriminant is not negative.
  struct Quadratic {
    Dyadic a, b, c;
  };
  /// Internal: a time of contact with the inside of a face, (p - radius sqrt(square)) / rate. The
  /// rate is positive.
  struct OfPlane {
    Dyadic p, radius, square, rate;
    /// the end comes from the side on which the face's corners run counter-clockwise
    bool front = true;
  };

 private:
  enum class Part { kCorner, kEdge, kInside };

  /// A contact at the limit t, for a capsule that met the triangle before.
  explicit CapsuleContact(double t) : t_(t) {}
  CapsuleContact(Part part, std::size_t at, Quadratic t) : part_(part), at_(at), t_(t) {}
  CapsuleContact(std::size_t face, OfPlane t) : part_(Part::kInside), at_(face), t_(t) {}
  static std::optional<CapsuleContact> on_line(const SweepPath& path, const SweptCapsule& capsule,
                                               const Triangle& triangle);
  RootNumber value() const;
  int compare_to(const Dyadic& numerator, const Dyadic& divisor) const;

  Part part_ = Part::kInside;
  std::size_t at_ = 0;  ///< corner, edge or face of the prism
  std::variant<double, Quadratic, OfPlane> t_;
};

}  // namespace sightline

// Tests: tests/unit/trace/sweep_test.cpp
