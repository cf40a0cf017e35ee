#pragma once
/// Rays and boxes made to be hard, from seeds, and their judge.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/box3.h"
#include "core/geometry/box_oriented.h"
#include "core/query/ray_batch.h"
#include "tests/oracle/random.h"

namespace sightline::stress {

struct RayBoxCase {
  Ray ray;
  Box3d aligned;
  std::optional<OrientedBox> oriented;  ///< if set, the box is this one
};

struct RayBoxFamily {
  std::string_view name;
  int weight;  ///< cases of this family in one round: a third of all pairs are to touch exactly
  RayBoxCase (*make)(oracle::Random& random);
};
std::span<const RayBoxFamily> ray_box_families();

struct RayBoxVerdict {
  std::string fault;      ///< empty: the answer is right in every part
  bool hit = false;       ///< what the oracle says
  bool touching = false;  ///< an equality decided: a corner, an edge, a face's plane, a limit
};
/// Compares ray_box and ray_box_planes with the oracle, every field.
RayBoxVerdict judge(const RayBoxCase& test);

/// A pair for which a kernel's batch does not answer as ray_box, every field.
struct RayBoxDifference {
  std::size_t number = 0;  ///< of the pair
  std::string fault;
};
std::vector<RayBoxDifference> differing_kernels(std::span<const RayBoxCase> cases);

std::string describe(const RayBoxCase& test);

}  // namespace sightline::stress
