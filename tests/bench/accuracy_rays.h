#pragma once
/// The rays and pairs of the accuracy benchmark, from seeds.

#include <vector>

#include "core/geometry/box3.h"
#include "core/query/box_batch.h"
#include "tests/bench/bench_rays.h"

namespace sightline::bench {

struct AccuracyRays {
  std::string group;
  RaySet set;
};

/// ordinary      the rays of the trace benchmark, about 4 * count of each kind
/// hard_float32  `count` rays of each of several families of tests/stress, every number rounded to
///               float32: all contestants get the same rays
/// hard_float64  similar families as they are: who computes in float32 rounds the ray
/// far_float32, far_float64  origins 1e5 to 1e8 scene sizes away, count / 32 rays each
/// Limits of hard and far rays are 0 and +inf.
std::vector<AccuracyRays> make_accuracy_rays(const BenchScene& scene, std::size_t count,
                                             std::uint64_t seed);

struct AccuracyPairs {
  std::string group, family;
  std::vector<Ray> rays;
  std::vector<Box3d> boxes;  ///< as many, axis-aligned
  RayBatch ray_batch;        ///< the pairs as columns
  BoxBatch box_batch;
};

/// ordinary: 4 * count random boxes, every other ray aimed at a point inside. hard: `count` pairs
/// of each of several families of tests/stress.
std::vector<AccuracyPairs> make_accuracy_pairs(std::size_t count, std::uint64_t seed);

}  // namespace sightline::bench
