#pragma once
/// The judge of distances: the nearest point of a triangle in rational arithmetic. Every corner,
/// every edge's foot and the plane's foot is tried and the nearest kept, so that no region is told
/// by a sign as the product does.

#include "tests/oracle/exact_triangle.h"

namespace sightline::oracle {

struct NearestPoint {
  mpq_class square;  ///< of the distance
  std::array<mpq_class, 3> position;
  mpq_class u, v;        ///< weights of v1 and v2
  bool on_edge = false;  ///< on an edge or a corner
  bool front = false;    ///< the asking point is on the counter-clockwise side
};
/// Preconditions: finite, and the triangle has an area.
NearestPoint nearest(const Vec3d& point, const Triangle& triangle);

/// Whether `rounded` is the float64 nearest to the root of `square`: ties do not occur among them.
bool is_rounded_root(double rounded, const mpq_class& square);

}  // namespace sightline::oracle
