#include <algorithm>
#include <cstdio>

#include "core/trace/kernel/kernel.h"
#include "tests/bench/contestant.h"

namespace sightline::bench {

namespace {

/// Which sides of triangles count.
enum class Sides { kUnfiltered, kAll, kFront };
struct BatchSize {
  const char* name;
  std::size_t rays;
  Sides sides = Sides::kUnfiltered;
};
constexpr BatchSize kBatchSizes[] = {{"sightline", 262'144},
                                     {"sightline_1024", 1'024},
                                     {"sightline_64", 64},
                                     {"sightline_1", 1},
                                     {"sightline_keep_all", 262'144, Sides::kAll},
                                     {"sightline_keep_fronts", 262'144, Sides::kFront}};

/// Calls the kernel as one thread of the engine does, a batch at a time. The trees are looked up
/// once for all rays, as Embree's scene is committed once: a query holds them for as long as it
/// runs.
class SightlineContestant : public Contestant {
 public:
  SightlineContestant(std::string name, std::size_t batch, const Kernel& kernel, const Scene& scene,
                      Sides sides)
      : Contestant(std::move(name)), batch_(batch), kernel_(kernel), scene_(scene) {
    if (sides == Sides::kUnfiltered) return;
    for (const Instance& instance : scene.description().instances) {
      kept_.first.push_back(kept_.sides.size());
      const auto& primitives = scene.description().meshes[instance.mesh]->primitives;
      const std::uint8_t some =
          sides == Sides::kAll ? ResolvedFilter::kAll : ResolvedFilter::kFront;
      kept_.sides.insert(kept_.sides.end(), primitives.size(), some);
    }
    is_filtered_ = true;
    is_exact_ = sides == Sides::kAll;
  }

  /// What a filter leaves out is not wrong, but not comparable.
  bool exact() const override { return is_exact_; }
  bool float64() const override { return true; }

  void closest(const RaySet& rays, Answers& answers) const override {
    TraceCounts counts;
    run_closest(rays, answers.hits, counts);
  }

  void any(const RaySet& rays, Answers& answers) const override {
    TraceCounts counts;
    run_any(rays, answers.occluded.data(), counts);
  }

  std::string explain(const RaySet& rays) const override {
    TraceCounts counts;
    HitBatch hits;
    hits.resize(rays.size());
    run_closest(rays, hits, counts);
    const auto per_ray = [&](std::uint64_t count) {
      return static_cast<double>(count) / static_cast<double>(rays.size());
    };
    const auto per_packet = [&](std::uint64_t count) {
      return static_cast<double>(count) * 16 /
             static_cast<double>(std::max<std::uint64_t>(1, counts.packet_rays));
    };
    char text[320];
    std::snprintf(text, sizeof text,
                  "%.2f nodes, %.2f blocks, %.2f placements, %.4f exact hits, %.4f exact compares, "
                  "%.2f in packets of %.1f nodes, %.1f boxes, %.1f leaves",
                  per_ray(counts.nodes), per_ray(counts.blocks), per_ray(counts.placements),
                  per_ray(counts.decisions.exact_hits), per_ray(counts.decisions.exact_compares),
                  per_ray(counts.packet_rays), per_packet(counts.packet_nodes),
                  per_packet(counts.packet_boxes), per_packet(counts.packet_leaves));
    TraceCounts any_counts;
    Column<std::uint8_t> occluded(rays.size());
    run_any(rays, occluded.data(), any_counts);
    char any_text[80];
    std::snprintf(any_text, sizeof any_text, "; any: %.2f nodes, %.2f blocks",
                  per_ray(any_counts.nodes), per_ray(any_counts.blocks));
    return std::string(kernel_.name) + ": " + text + any_text;
  }

 private:
  void run_closest(const RaySet& rays, HitBatch& hits, TraceCounts& counts) const {
    const SceneView view(scene_);
    for (std::size_t i = 0; i < rays.size(); i += batch_) {
      const std::size_t end = std::min(i + batch_, rays.size());
      if (is_filtered_) {
        kernel_.closest_filtered(view, rays.rays, i, end, kept_, hits, counts);
      } else {
        kernel_.closest(view, rays.rays, i, end, hits, counts);
      }
    }
  }
  void run_any(const RaySet& rays, std::uint8_t* occluded, TraceCounts& counts) const {
    const SceneView view(scene_);
    for (std::size_t i = 0; i < rays.size(); i += batch_) {
      const std::size_t end = std::min(i + batch_, rays.size());
      if (is_filtered_) {
        kernel_.any_filtered(view, rays.rays, i, end, kept_, occluded, counts);
      } else {
        kernel_.any(view, rays.rays, i, end, occluded, counts);
      }
    }
  }

  std::size_t batch_;
  Kernel kernel_;
  const Scene& scene_;
  ResolvedFilter kept_;
  bool is_filtered_ = false, is_exact_ = true;
};

}  // namespace

std::vector<std::string> sightline_names() {
  std::vector<std::string> names;
  for (const BatchSize& size : kBatchSizes) names.emplace_back(size.name);
  for (const Kernel& kernel : supported_kernels()) {
    for (const BatchSize& size : kBatchSizes)
      names.push_back(std::string(size.name) + "@" + std::string(kernel.name));
  }
  return names;
}

std::unique_ptr<Contestant> make_sightline(const std::string& name, const std::string& kernel,
                                           const BenchScene& scene) {
  const std::size_t at = name.find('@');
  const std::string wanted = at == std::string::npos ? kernel : name.substr(at + 1);
  for (const Kernel& candidate : supported_kernels()) {
    if (!wanted.empty() && candidate.name != wanted) continue;
    for (const BatchSize& size : kBatchSizes) {
      if (name.substr(0, at) == size.name) {
        return std::make_unique<SightlineContestant>(name, size.rays, candidate, *scene.scene,
                                                     size.sides);
      }
    }
  }
  return nullptr;
}

}  // namespace sightline::bench
