#pragma once
/// Small scenes that are hard on trees: placements turned, mirrored, sheared and flattened, tiny
/// and huge ones, duplicates, triangles without area and, where placements are joined, one position
/// that is not a number.

#include <initializer_list>
#include <memory>
#include <vector>

#include "core/scene/scene.h"
#include "tests/oracle/random.h"

namespace sightline::test {

/// Of the mesh that every case has.
inline constexpr std::uint32_t kTriangles = 150;

struct Case {
  const char* name;
  float scale = 1;
  float shift = 0;
  bool grid = false;
  std::vector<Affine> places;  ///< empty: one identity
  Joining joining = Joining::kMeasured;
};

/// Twelve numbers by rows.
Affine affine(std::initializer_list<double> rows);
std::vector<Case> cases();
/// The scene of a case; another one with every call.
std::shared_ptr<const Scene> make_scene(const Case& c, oracle::Random& random);

}  // namespace sightline::test
