#pragma once
/// Makes the smallest scene and the one ray on which Sightline is still wrong, or still crashes.

#include <optional>
#include <string>

#include "core/bvh/scene_tree.h"
#include "tests/stress/case.h"

namespace sightline::stress {

struct SmallestCase {
  SceneDescription scene;
  Ray ray;
  std::string fault;  ///< what is wrong with it
};

/// Why Sightline's answer to the ray is wrong in any mode, asked alone and among copies of itself;
/// empty if it is right. Runs in a process of its own, so that a crash is an answer too.
std::string fault_of(const SceneDescription& scene, const Ray& ray, const std::string& kernel,
                     Joining joining = Joining::kMeasured);

/// Nothing if every ray of the case is answered rightly.
std::optional<SmallestCase> shrink(const Case& failing, const std::string& kernel, Joining joining);

/// Every number in hexadecimal, ready to become a test.
std::string describe(const SmallestCase& smallest);

}  // namespace sightline::stress
