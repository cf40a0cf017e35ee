#include "tests/bench/scene_judge.h"

#include <algorithm>

namespace sightline::bench {

namespace {

/// What fits in memory as a list of float64 triangles.
constexpr std::uint64_t kListedMax = 4'000'000;

oracle::Triangle triangle_of(const Scene& scene, TriangleId id) {
  const WorldTriangle t = scene.world_triangle(id);
  return {t.v0, t.v1, t.v2};
}

}  // namespace

SceneJudge::SceneJudge(const Scene& scene) : scene_(scene) {
  const SceneDescription& description = scene.description();
  if (scene.instanced_triangle_count() > kListedMax) {
    for (const Instance& instance : description.instances) {
      const Mesh& mesh = *description.meshes[instance.mesh];
      Box3d box;
      for (std::uint32_t index : mesh.indices) {
        box.include(instance.world_from_mesh.apply(mesh.positions[index]));
      }
      bounds_.push_back({box.min, box.max});
    }
    return;
  }
  std::vector<oracle::Triangle> triangles;
  triangles.reserve(scene.instanced_triangle_count());
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    first_.push_back(triangles.size());
    const std::uint32_t count = description.meshes[description.instances[i].mesh]->triangle_count();
    for (std::uint32_t k = 0; k < count; ++k) triangles.push_back(triangle_of(scene, {i, k}));
  }
  listed_ = std::make_unique<oracle::SceneOracle>(triangles);
}

std::optional<SceneJudge::Verdict> SceneJudge::closest(const Ray& ray) const {
  if (!listed_) return closest_of_placements(ray);
  auto hit = listed_->closest(ray);
  if (!hit) return std::nullopt;
  const auto after = std::upper_bound(first_.begin(), first_.end(), hit->triangle);
  const auto instance = static_cast<std::size_t>(after - first_.begin()) - 1;
  return Verdict{{static_cast<std::uint32_t>(instance),
                  static_cast<std::uint32_t>(hit->triangle - first_[instance])},
                 std::move(hit->t),
                 hit->t_rounded};
}

std::optional<SceneJudge::Verdict> SceneJudge::closest_of_placements(const Ray& ray) const {
  struct Candidate {
    double near;
    std::uint32_t instance;
  };
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
    const oracle::Overlap overlap = oracle::overlap(ray, bounds_[i], ray.tmax);
    if (!overlap.empty()) candidates.push_back({overlap.low, i});
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.near < b.near; });
  const SceneDescription& description = scene_.description();
  std::optional<Verdict> best;
  double bound = ray.tmax;
  for (const Candidate& candidate : candidates) {
    if (candidate.near > bound) break;
    const Mesh& mesh = *description.meshes[description.instances[candidate.instance].mesh];
    for (std::uint32_t k = 0; k < mesh.triangle_count(); ++k) {
      const TriangleId id{candidate.instance, k};
      const oracle::Triangle triangle = triangle_of(scene_, id);
      if (!oracle::may_meet(ray, triangle, bound)) continue;
      auto t = oracle::least_t(ray, triangle);
      if (!t) continue;
      const int order = best ? oracle::compare(*t, best->t) : -1;
      if (order > 0 || (order == 0 && best->id < id)) continue;
      const double rounded = oracle::round_to_double(*t);
      best = Verdict{id, std::move(*t), rounded};
      bound = oracle::next_up(rounded);
    }
  }
  return best;
}

bool SceneJudge::is_tie(const Ray& ray, TriangleId id, const oracle::Rational& t) const {
  const auto own = oracle::least_t(ray, triangle_of(scene_, id));
  return own && oracle::compare(*own, t) == 0;
}

}  // namespace sightline::bench
