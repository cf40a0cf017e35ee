#pragma once
/// Embree's build alone: the arrays lie ready, as they do for Sightline.

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/scene/scene_description.h"

namespace sightline::bench {

class EmbreeBuild {
 public:
  /// Every mesh of the description once, not placed.
  EmbreeBuild(const SceneDescription& description, int threads, RTCBuildQuality quality);
  EmbreeBuild(const EmbreeBuild&) = delete;
  EmbreeBuild& operator=(const EmbreeBuild&) = delete;
  ~EmbreeBuild();

  /// Returns the bytes that Embree holds for the tree.
  double build();
  /// Forgets what was built.
  void drop();

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  RTCBuildQuality quality_;
  const SceneDescription& description_;
  /// Embree reads 16 bytes per vertex: the arrays need room at their end.
  std::vector<std::vector<float>> vertices_;
  std::vector<std::vector<std::uint32_t>> indices_;  ///< listed, whatever the mesh has
  std::atomic<long> held_{0};
};

}  // namespace sightline::bench
