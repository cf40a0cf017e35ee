#pragma once
/// A family of rays: a scene and rays made from a seed, hard in one stated way.

#include <functional>
#include <string>
#include <vector>

#include "core/query/ray_batch.h"
#include "core/scene/scene_description.h"
#include "tests/oracle/exact_triangle.h"
#include "tests/oracle/random.h"

namespace sightline::stress {

using oracle::Random;
using oracle::Triangle;

struct Case {
  SceneDescription scene;
  RayBatch rays;
  /// Every edge belongs to an even number of triangles with the same two float64 ends: a whole line
  /// crosses it an even number of times, an inner point sees an odd number.
  bool closed = false;
};

struct Family {
  std::string name;
  std::string what;  ///< one sentence for the report
  /// A new scene and `count` rays; the same for the same state of the source.
  std::function<Case(Random&, std::size_t count)> make;
};

/// The rows of the contract's table.
std::vector<Family> contract_families();
/// Where a ray starts, where it may end, and what it touches.
std::vector<Family> contact_families();
/// Magnitudes: tiny, huge, mixed, any bit pattern.
std::vector<Family> magnitude_families();
/// Placements: sheared, mirrored, flattened, flush, far.
std::vector<Family> placement_families();
/// Rays side by side.
std::vector<Family> neighbour_families();
/// Failures of Embree that its users published, rebuilt from the words of the threads.
std::vector<Family> published_families();

/// All of the above, in this order; names are unique.
std::vector<Family> families();

}  // namespace sightline::stress
