#pragma once
/// The four kinds of rays: camera, LiDAR, AO (ambient occlusion) and incoherent.

#include <vector>

#include "tests/bench/bench_scene.h"
#include "tests/bench/ray_set.h"

namespace sightline::bench {

struct RayCounts {
  unsigned views = 5;        ///< camera: pictures of 512 x rows, row after row
  unsigned rows = 512;       ///< camera and AO: the middle rows of each picture
  unsigned azimuths = 2048;  ///< LiDAR: of each of 128 beams, beam after beam
  unsigned others = 262144;  ///< incoherent; AO has at most as many

  static RayCounts full() { return {}; }
  static RayCounts quick() { return {3, 128, 512, 65536}; }
};

/// In this order: camera, lidar, ao, incoherent.
///   camera      one ray per pixel, 60 degrees across
///   lidar       a sensor in the scene, elevations -25 to 15 degrees
///   ao          one cosine-distributed ray per camera hit, 0.08 of the scene's diagonal long
///   incoherent  uniform origin in the scene's bounds, uniform direction
std::vector<RaySet> make_ray_sets(const BenchScene& scene, const RayCounts& counts);

}  // namespace sightline::bench
