#include "tests/bench/accuracy_rays.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/base/infinity.h"
#include "tests/stress/aimed_rays.h"
#include "tests/stress/ray_box_cases.h"

namespace sightline::bench {

namespace {

using oracle::Random;

/// Families whose rays stay hard when their numbers are rounded to float32.
constexpr std::array kFloat32Families{"vertex_aims", "edge_aims", "origin_on_surface", "grazing"};
constexpr std::array kFloat64Families{"near_edges_float64", "in_a_triangles_plane",
                                      "origin_on_surface", "grazing"};
/// So far away, float32 boxes are met in hundreds of thousands of nanoseconds per ray: a group of
/// its own, lest its time be all that a mean shows, and few rays.
constexpr const char* kFarFamily = "origin_far_away";
constexpr std::size_t kFarShare = 32;
constexpr std::array kBoxFamilies{"aimed_at_corners",
                                  "aimed_at_edges",
                                  "aimed_between_numbers",
                                  "aimed_with_long_differences",
                                  "in_a_face",
                                  "origin_on_the_surface",
                                  "limits_at_the_hit",
                                  "far_away"};

/// About `count` rays of each kind, neighbours side by side as in the trace benchmark.
RayCounts counts_of(std::size_t count) {
  RayCounts counts = RayCounts::full();
  const auto each = static_cast<unsigned>(count);
  counts.rows = std::max(1u, each / (counts.views * 512));
  counts.azimuths = std::max(1u, each / 128);
  counts.others = each;
  return counts;
}

/// The ray as it is for contestants in float64, rounded for those in float32.
void push_back_float64(RaySet& set, const Ray& ray) {
  set.push_back(ray);
  const std::size_t i = set.size() - 1;
  set.rays.ox[i] = ray.origin.x;
  set.rays.oy[i] = ray.origin.y;
  set.rays.oz[i] = ray.origin.z;
  set.rays.dx[i] = ray.direction.x;
  set.rays.dy[i] = ray.direction.y;
  set.rays.dz[i] = ray.direction.z;
}

RaySet hard_rays(const stress::Aim& aim, const char* family, std::size_t count, bool float32) {
  RaySet set;
  set.name = family;
  while (set.size() < count) {
    Ray ray = stress::aimed_family(family).ray(aim);
    ray.tmin = 0;
    ray.tmax = kInf;
    // No contestant is asked about a ray that float32 has no direction for.
    if (stress::as_float32(ray.direction) == Vec3d{}) continue;
    if (float32) {
      set.push_back(ray);
    } else {
      push_back_float64(set, ray);
    }
  }
  return set;
}

stress::RayBoxCase box_case(std::string_view family, Random& random) {
  for (const stress::RayBoxFamily& f : stress::ray_box_families()) {
    if (f.name == family) return f.make(random);
  }
  return {};
}

AccuracyPairs pairs_of(const char* group, const char* family, std::size_t count, Random& random) {
  AccuracyPairs pairs{group, family, {}, {}, {}, {}};
  const bool ordinary = pairs.group == "ordinary";
  for (std::size_t i = 0; i < count; ++i) {
    stress::RayBoxCase test = box_case(family, random);
    if (ordinary && i % 2 == 0) {
      for (int k = 0; k < 3; ++k) {
        test.ray.direction[k] =
            random.between(test.aligned.min[k], test.aligned.max[k]) - test.ray.origin[k];
      }
    }
    pairs.rays.push_back(test.ray);
    pairs.boxes.push_back(test.aligned);
    pairs.ray_batch.push_back(test.ray);
    pairs.box_batch.push_back(test.aligned);
  }
  return pairs;
}

}  // namespace

std::vector<AccuracyRays> make_accuracy_rays(const BenchScene& scene, std::size_t count,
                                             std::uint64_t seed) {
  std::vector<AccuracyRays> all;
  for (RaySet& set : make_ray_sets(scene, counts_of(4 * count))) {
    if (set.size() > 0) all.push_back({"ordinary", std::move(set)});
  }
  Random random(seed);
  const stress::Aim aim(scene.scene->description(), random);
  for (const char* family : kFloat32Families) {
    all.push_back({"hard_float32", hard_rays(aim, family, count, true)});
  }
  for (const char* family : kFloat64Families) {
    all.push_back({"hard_float64", hard_rays(aim, family, count, false)});
  }
  const std::size_t far_count = std::max<std::size_t>(1, count / kFarShare);
  all.push_back({"far_float32", hard_rays(aim, kFarFamily, far_count, true)});
  all.push_back({"far_float64", hard_rays(aim, kFarFamily, far_count, false)});
  return all;
}

std::vector<AccuracyPairs> make_accuracy_pairs(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<AccuracyPairs> all{pairs_of("ordinary", "ordinary", 4 * count, random)};
  for (const char* family : kBoxFamilies) all.push_back(pairs_of("hard", family, count, random));
  return all;
}

}  // namespace sightline::bench
