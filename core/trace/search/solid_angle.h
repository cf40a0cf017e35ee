#pragma once
/// The generalized winding number of open meshes [Jacobson2013] by their open edges.
///
/// Method   Let u be a direction. A mesh closes if each of its open edges a -> b is joined by a
///          triangle to one point at infinity, in the direction -u. A ray along u crosses none of
///          these triangles. The ray crosses so many backs and fronts that
///          their difference is the winding number of the closed surface. That of the mesh is the
///          difference plus the sum, over open edges, of angle(a - p, b - p, -u) / (4 pi). Here angle
///          is the signed solid angle of a triangle [VanOosterom1983]. A closed mesh has no such
///          edges, and its number is an integer.
/// Errors   Where the ray passes by an open edge, the sign of the solid angle is decided exactly,
///          for the displaced origin that Crossings::kOnce has (core/query/hit_batch.h).

#include <cstdint>
#include <vector>

#include "core/geometry/triangle.h"

namespace sightline {

/// An open edge in the world: the triangles run from `from` to `to` `times` times more often than
/// back.
struct OpenEdge {
  Vec3d from, to;
  double times = 1;
};

/// A number and a bound of its absolute error.
struct BoundedNumber {
  double value = 0;
  double error = 0;
};

/// The sum of `times` angle / (4 pi) over the edges, at p, for a direction u that is about of unit
/// length. Edges with an end that is not finite are left out. Every machine gives these bytes,
/// because it uses + - * / and square roots only. Cost: about 80 ns for each edge. Precondition: p is finite.
BoundedNumber winding_of_open_edges(const std::vector<OpenEdge>& edges, const Vec3d& p,
                                    const Vec3d& u);

}  // namespace sightline

// Tests: tests/unit/run/solid_angle_test.cpp
