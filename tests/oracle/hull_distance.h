#pragma once
/// The judge of distances between points, segments and triangles, and of triangles against
/// half-spaces, in rational arithmetic: every part of both is tried, and no sign tells a region.

#include <array>
#include <vector>

#include "core/geometry/vec3.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

using ExactPoint = std::array<mpq_class, 3>;
ExactPoint exact_point(const Vec3d& p);

/// The least squared distance of the convex hulls. For every choice of corners of both, the nearest
/// points of their affine hulls are solved for, and kept if all weights are not negative.
/// `away`, if it is not null, gets the vector from the point of b to that of a.
mpq_class hull_square_distance(const std::vector<ExactPoint>& a, const std::vector<ExactPoint>& b,
                               ExactPoint* away = nullptr);

/// normal . p <= offset
struct ExactHalfSpace {
  ExactPoint normal;
  mpq_class offset;
};
/// Whether the closed triangle has a point in all of them: some crossing of two of the lines in its
/// plane, or of a line with an edge, or a corner has.
bool meets_all(const Triangle& triangle, const std::vector<ExactHalfSpace>& planes);

}  // namespace sightline::oracle
