#pragma once
/// A scene as a competent user of Embree builds it, and the device that it belongs to.

#include <embree3/rtcore.h>

#include "core/query/hit_batch.h"
#include "tests/bench/bench_scene.h"

namespace sightline::bench {

struct EmbreeOptions {
  const char* device = "";  ///< rtcNewDevice's configuration, e.g. "isa=avx2"
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
};

/// One two-level scene: a mesh that is placed once is put there by its (rounded) world positions, a
/// mesh that is placed more often is instanced.
class EmbreeScene {
 public:
  EmbreeScene(const Scene& scene, const EmbreeOptions& options);
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene();

  RTCScene top() const { return top_; }
  bool has_instances() const { return has_instances_; }
  /// The number of the instance in the scene's file order.
  static std::uint32_t instance_of(unsigned geometry, unsigned instance) {
    return instance != RTC_INVALID_GEOMETRY_ID ? instance : geometry;
  }

 private:
  RTCDevice device_ = nullptr;
  RTCScene top_ = nullptr;
  bool has_instances_ = false;
};

}  // namespace sightline::bench
