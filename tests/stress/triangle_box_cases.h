#pragma once
/// Triangles and boxes that nearly touch, touch, or just miss, from seeds, and their judge.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/geometry/triangle.h"
#include "tests/oracle/random.h"

namespace sightline::stress {

struct TriangleBoxCase {
  Triangle triangle;
  Box3d aligned;
  std::optional<OrientedBox> oriented;  ///< if set, the box is this one
};

struct TriangleBoxFamily {
  std::string_view name;
  int weight;  ///< cases of this family in one round: a third of all pairs are to touch exactly
  TriangleBoxCase (*make)(oracle::Random& random);
};
std::span<const TriangleBoxFamily> triangle_box_families();

struct TriangleBoxVerdict {
  std::string fault;      ///< empty: the answer and every stage are right
  bool meets = false;     ///< what the oracle says
  bool touching = false;  ///< they share points, and none if the box were a trifle smaller
  bool filtered = false;  ///< the filter decided
  bool no_area = false;   ///< the triangle is none, and meets nothing
};
TriangleBoxVerdict judge(const TriangleBoxCase& test);

std::string describe(const TriangleBoxCase& test);

}  // namespace sightline::stress
