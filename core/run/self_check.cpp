#include "core/run/self_check.h"

#include <algorithm>
#include <array>
#include <new>
#include <span>
#include <vector>

#include "core/base/split_mix.h"
#include "core/base/watch.h"
#include "core/trace/decision.h"

namespace sightline {

namespace {

/// To draw one, in steps of a DeadlineWatch.
constexpr std::uint64_t kStepsPerRay = 64;

class Random : public SplitMix {
 public:
  using SplitMix::SplitMix;
  std::uint64_t below(std::uint64_t count) { return bits() % count; }
};

std::uint32_t triangles_of(const Scene& scene, std::uint32_t instance) {
  const SceneDescription& description = scene.description();
  return description.meshes[description.instances[instance].mesh]->triangle_count();
}

/// The instances that have triangles and are not hidden, in their order: of a million one may be
/// all that there is to see. Cut short where the watch has passed.
Column<std::uint32_t> visible_instances(const Scene& scene, DeadlineWatch& watch) {
  Column<std::uint32_t> visible;
  const auto& instances = scene.description().instances;
  visible.reserve(instances.size());
  for (std::uint32_t i = 0; i < instances.size() && !watch.passed(); ++i)
    if (!instances[i].hidden && triangles_of(scene, i) > 0) visible.push_back(i);
  return visible;
}

/// Precondition: there is one.
TriangleId some_triangle(const Scene& scene, const Column<std::uint32_t>& visible, Random& random) {
  const std::uint32_t instance = visible[random.below(visible.size())];
  return {instance, static_cast<std::uint32_t>(random.below(triangles_of(scene, instance)))};
}

/// A corner, a point near an edge, one near the inside, or one beside the triangle.
Vec3d aim(const WorldTriangle& triangle, Random& random) {
  const std::uint64_t kind = random.below(4);
  if (kind == 0) return triangle.v0;
  const double a = random.unit() * (kind == 3 ? 2 : 1), b = kind == 1 ? 0 : random.unit() * (1 - a);
  Vec3d point;
  for (int k = 0; k < 3; ++k) {
    point[k] = triangle.v0[k] + a * (triangle.v1[k] - triangle.v0[k]) +
               b * (triangle.v2[k] - triangle.v0[k]);
  }
  return point;
}

/// Fewer where the watch has passed.
RayBatch random_rays(const Scene& scene, const Column<std::uint32_t>& visible, std::uint64_t count,
                     Random& random, DeadlineWatch& watch) {
  RayBatch rays;
  const Box3d& bounds = scene.bounds();
  // A ray may be none (a triangle with a position that is not finite, an aim at the origin itself):
  // it is drawn anew, but not for ever.
  for (std::uint64_t tries = 0;
       rays.size() < count && tries < 16 * count && !watch.passed(kStepsPerRay); ++tries) {
    Ray ray;
    const Vec3d target = aim(scene.world_triangle(some_triangle(scene, visible, random)), random);
    for (int k = 0; k < 3; ++k) {
      const double size = bounds.max[k] - bounds.min[k];
      ray.origin[k] = bounds.min[k] + (2 * random.unit() - 0.5) * size;
      ray.direction[k] = target[k] - ray.origin[k];
    }
    if (random.below(4) == 0) ray.tmin = 0.5;
    if (random.below(4) == 0) ray.tmax = 1;
    RayBatch one;
    one.push_back(ray);
    RayFault fault;
    if (check_rays(one, fault)) rays.push_back(ray);
  }
  return rays;
}

struct BruteForce {
  TriangleId closest;
  ExactT t;
  std::uint64_t count = 0;
};

/// Rays that brute force tests against a triangle before it reads the next.
constexpr std::size_t kRays = 64;
/// A test of a ray and a triangle, in steps of a DeadlineWatch.
constexpr std::uint64_t kSteps = 8;

/// Tests rays [first, first + brute.size()) of the batch. Returns false when the time was used up.
bool try_all(const Scene& scene, const Column<std::uint32_t>& visible, const RayBatch& rays,
             std::size_t first, const Deadline& deadline, std::span<BruteForce> brute,
             std::uint64_t& decided) {
  std::array<Ray, kRays> ray;
  for (std::size_t r = 0; r < brute.size(); ++r) ray[r] = rays[first + r];
  DeadlineWatch watch(deadline);
  ExactT t;
  for (const std::uint32_t i : visible) {
    const std::uint32_t triangles = triangles_of(scene, i);
    for (std::uint32_t k = 0; k < triangles; ++k) {
      if (watch.passed(kSteps * brute.size())) return false;
      decided += brute.size();
      const TriangleId id{i, k};
      const WorldTriangle triangle = scene.world_triangle(id);
      for (std::size_t r = 0; r < brute.size(); ++r) {
        if (!exact_hit(ray[r].origin, ray[r].direction, ray[r].tmin, ray[r].tmax, triangle, t))
          continue;
        // In the order of ids: of equal t the first stays.
        if (brute[r].count++ == 0 || compare(t, brute[r].t) < 0) {
          brute[r].closest = id;
          brute[r].t = t;
        }
      }
    }
  }
  return true;
}

}  // namespace

std::uint64_t self_check_bytes(std::uint64_t rays) {
  return std::min<std::uint64_t>(kRays, rays) * sizeof(BruteForce);
}

Result<SelfCheck> self_check(const Engine& engine, const Scene& scene, std::uint64_t rays,
                             std::uint64_t seed, const Deadline& deadline) try {
  SelfCheck check;
  if (scene.bounds().empty()) return check;
  Random random(seed);
  DeadlineWatch watch(deadline);
  const Column<std::uint32_t> visible = visible_instances(scene, watch);
  if (visible.empty() && !watch.passed(0)) return check;
  const RayBatch batch = random_rays(scene, visible, rays, random, watch);
  if (watch.passed(0)) return watch.error();
  check.rays = batch.size();
  HitBatch hits;
  Column<std::uint64_t> counts;
  Status status = engine.closest(scene, batch, deadline, hits);
  if (status) status = engine.count(scene, batch, Crossings::kEvery, deadline, counts);
  if (!status) return status.error();
  std::vector<BruteForce> memory(std::min(kRays, batch.size()));
  for (std::size_t first = 0; first < batch.size(); first += kRays) {
    const auto brutes = std::span(memory).first(std::min(kRays, batch.size() - first));
    for (BruteForce& brute : brutes) {
      brute.closest = {};
      brute.count = 0;
    }
    if (!try_all(scene, visible, batch, first, deadline, brutes, check.triangles))
      return out_of_time(deadline);
    for (std::size_t r = 0; r < brutes.size(); ++r) {
      const BruteForce& brute = brutes[r];
      const std::size_t i = first + r;
      check.hits += brute.count > 0 ? 1u : 0u;
      const bool same = counts[i] == brute.count && hits.id(i) == brute.closest &&
                        (brute.count == 0 || hits.t[i] == brute.t.rounded());
      if (!same) check.different.push_back(i);
    }
  }
  return check;
} catch (const std::bad_alloc&) {
  return Error{ErrorKind::kOutOfSpace, "MEMORY_EXHAUSTED", "there is no memory for the check", ""};
}

}  // namespace sightline
