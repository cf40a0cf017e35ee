// How time and memory grow with the number of triangles and of instances, and how Embree's time
// does.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/demo/demo.h"
#include "core/trace/kernel/kernel.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/contestant.h"
#include "tests/bench/machine.h"
#include "tests/bench/scale_report.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {
namespace {

/// Straight from the generator: a GLB of 16 million triangles would only measure the disk.
SceneDescription description_of(demo::DemoScene scene) {
  SceneDescription description;
  for (demo::DemoMesh& from : scene.meshes) {
    auto mesh = std::make_shared<Mesh>();
    UnsetColumn<Vec3f>& positions = mesh->positions.own();
    positions.resize(from.positions.size() / 3);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const float* p = &from.positions[3 * i];
      positions[i] = {p[0], p[1], p[2]};
    }
    mesh->indices.own().assign(from.indices.begin(), from.indices.end());
    mesh->primitives.push_back({0, mesh->triangle_count(), 0});
    from = {};
    description.meshes.push_back(std::move(mesh));
  }
  for (const demo::DemoNode& node : scene.nodes) {
    const auto number = static_cast<std::uint32_t>(description.nodes.size());
    description.nodes.push_back({"", number, 0xffffffffu, node.parent_from_node});
    description.instances.push_back(
        {static_cast<std::uint32_t>(node.mesh), number, node.parent_from_node});
  }
  return description;
}

double peak_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib / 1024;
  }
  return 0;
}

/// Rays in batches so small that what they visit stays in the second-level cache, each batch traced
/// by `before` and then by `kernel`, whose time counts. If both are the same the processor has
/// learned the branches as well; another kernel has its own.
double batches_ns_per_ray(const Kernel& before, const Kernel& kernel, const Scene& scene,
                          const RayBatch& rays, HitBatch& hits) {
  constexpr std::size_t kBatch = 512;
  TraceCounts counts;
  double sum = 0;
  for (std::size_t begin = 0; begin < rays.size(); begin += kBatch) {
    const std::size_t end = std::min(rays.size(), begin + kBatch);
    before.closest(scene, rays, begin, end, hits, counts);
    const double start = thread_time_ns();
    kernel.closest(scene, rays, begin, end, hits, counts);
    sum += thread_time_ns() - start;
  }
  return sum / static_cast<double>(rays.size());
}

std::optional<BenchScene> make_scene(const std::string& subject, std::uint64_t size) {
  const auto count = static_cast<std::uint32_t>(size);
  const bool triangles = subject == "triangles";
  SceneDescription description =
      description_of(triangles ? demo::terrain(count) : demo::instances(count, 2'000));
  const double start = wall_time_seconds();
  auto built = Scene::build(std::move(description));
  const double build_seconds = wall_time_seconds() - start;
  if (!built) return {};
  return BenchScene{subject, triangles ? Viewpoints::kGround : Viewpoints::kWithin,
                    std::move(*built), build_seconds};
}

using Rows = std::vector<ScaleRow>;

Rows measure(const std::string& subject, std::uint64_t size, int repetitions) {
  const std::optional<BenchScene> scene = make_scene(subject, size);
  if (!scene) return {};
  const std::shared_ptr<const SceneTree> trees = scene->scene->tree();
  double tree_bytes = static_cast<double>(trees->top.arena.used());
  for (const auto& tree : trees->trees) {
    tree_bytes += static_cast<double>(tree->arena.used());
  }

  const Pin pin(-1);
  const std::vector<Kernel> kernels = supported_kernels();
  const Kernel& kernel = kernels.front();
  const Kernel& another = kernels[kernels.size() > 1 ? 1 : 0];
  Rows rows;
  for (const RaySet& rays : make_ray_sets(*scene, RayCounts::quick())) {
    HitBatch hits;
    hits.resize(rays.size());
    std::vector<double> times, warm_times, learned_times;
    TraceCounts counts;
    for (int repetition = -1; repetition < repetitions; ++repetition) {
      counts = {};
      const double before = thread_time_ns();
      kernel.closest(*scene->scene, rays.rays, 0, rays.size(), hits, counts);
      const double time = (thread_time_ns() - before) / static_cast<double>(rays.size());
      const double warm = batches_ns_per_ray(another, kernel, *scene->scene, rays.rays, hits);
      const double learned = batches_ns_per_ray(kernel, kernel, *scene->scene, rays.rays, hits);
      if (repetition < 0) continue;
      times.push_back(time);
      warm_times.push_back(warm);
      learned_times.push_back(learned);
    }
    const Spread time = spread_of(times);
    const auto per_ray = [&](std::uint64_t n) {
      return static_cast<double>(n) / static_cast<double>(rays.size());
    };
    ScaleRow row;
    row.subject = subject;
    row.rays = rays.name;
    row.size = size;
    row.ns_per_ray = time.median;
    row.least = time.least;
    row.most = time.most;
    row.warm_ns_per_ray = spread_of(warm_times).median;
    row.learned_ns_per_ray = spread_of(learned_times).median;
    row.nodes_per_ray = per_ray(counts.nodes);
    row.blocks_per_ray = per_ray(counts.blocks);
    row.build_seconds = scene->build_seconds;
    row.tree_bytes = tree_bytes;
    row.peak_mib = peak_mib();
    rows.push_back(row);
  }
  return rows;
}

/// Rows with nothing but what Embree takes for the same rays.
Rows measure_embree(std::uint64_t size, int repetitions) {
  const std::optional<BenchScene> scene = make_scene("triangles", size);
  if (!scene) return {};
  const auto contestants =
      make_embree({"embree1", "embree8_coherent", "embree8_incoherent", "embree16_coherent",
                   "embree16_incoherent", "embree_stream_coherent", "embree_stream_incoherent"},
                  *scene);
  const Pin pin(-1);
  Rows rows;
  for (const RaySet& rays : make_ray_sets(*scene, RayCounts::quick())) {
    Answers answers;
    answers.resize(rays.size());
    std::vector<std::vector<double>> times(contestants.size());
    for (int repetition = -1; repetition < repetitions; ++repetition) {
      for (std::size_t i = 0; i < contestants.size(); ++i) {
        const double before = thread_time_ns();
        contestants[i]->closest(rays, answers);
        const double time = (thread_time_ns() - before) / static_cast<double>(rays.size());
        if (repetition >= 0) times[i].push_back(time);
      }
    }
    ScaleRow row;
    row.embree_ns = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      const double time = spread_of(times[i]).median;
      if (contestants[i]->name() == "embree1") row.embree1_ns = time;
      if (time >= row.embree_ns) continue;
      row.embree_ns = time;
      row.embree = contestants[i]->name();
    }
    rows.push_back(row);
  }
  return rows;
}

/// In a process of its own, so that the peak of memory is that of this size.
template <class Measure>
Rows measure_apart(const Measure& measure) {
  const std::string text = in_own_process([&] { return nlohmann::json(measure()).dump(); });
  if (text.empty()) return {};
  return nlohmann::json::parse(text).get<Rows>();
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  using namespace sightline::bench;
  start_again_with_huge_pages(argv);

  std::string out;
  std::uint64_t most_triangles = 0, most_instances = 0;
  int repetitions = 0;
  bool quick = false;
  CLI::App app("Time per ray and memory as scenes grow.");
  app.add_option("--triangles", most_triangles, "the largest terrain (default 16777216)");
  app.add_option("--instances", most_instances, "the most instances (default 1000000)");
  app.add_option("--repetitions", repetitions, "default 5, quick 3");
  app.add_option("--out", out, "write scale.json, scale.csv and scale.md to this folder");
  app.add_flag("--quick", quick, "up to 1048576 triangles and 10000 instances");
  CLI11_PARSE(app, argc, argv);
  if (repetitions <= 0) repetitions = quick ? 3 : 5;
  if (most_triangles == 0) most_triangles = quick ? 1u << 20 : 1u << 24;
  if (most_instances == 0) most_instances = quick ? 10'000 : 1'000'000;

  std::vector<std::pair<std::string, std::uint64_t>> sizes;
  for (std::uint64_t n = 1024; n <= most_triangles; n *= 4) sizes.emplace_back("triangles", n);
  for (std::uint64_t n = 1; n <= most_instances; n *= 10) sizes.emplace_back("instances", n);
  Rows rows;
  for (const auto& entry : sizes) {
    const std::string& subject = entry.first;
    const std::uint64_t size = entry.second;
    Rows more = measure_apart([&] { return measure(subject, size, repetitions); });
    if (subject == "triangles") {
      const Rows theirs = measure_apart([&] { return measure_embree(size, repetitions); });
      for (std::size_t i = 0; i < more.size() && i < theirs.size(); ++i) {
        more[i].embree1_ns = theirs[i].embree1_ns;
        more[i].embree_ns = theirs[i].embree_ns;
        more[i].embree = theirs[i].embree;
      }
    }
    if (more.empty()) {
      std::fprintf(stderr, "scale_bench: %llu %s could not be measured\n",
                   static_cast<unsigned long long>(size), subject.c_str());
      return 1;
    }
    std::printf("%9llu %-9s built in %.2f s, tree %.1f MiB, peak %.0f MiB;",
                static_cast<unsigned long long>(size), subject.c_str(), more[0].build_seconds,
                more[0].tree_bytes / (1 << 20), more.back().peak_mib);
    for (const ScaleRow& row : more) {
      std::printf(" %s %.0f ns", row.rays.c_str(), row.ns_per_ray);
      if (row.embree_ns > 0) std::printf(" (Embree %.0f)", row.embree_ns);
    }
    std::printf("\n");
    std::fflush(stdout);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  for (const std::string& line : scale_growth(rows)) std::printf("%s\n", line.c_str());
  for (const std::string& line : scale_floors(rows)) std::printf("%s\n", line.c_str());
  if (!out.empty() && !write_scale_report(rows, out)) {
    std::fprintf(stderr, "scale_bench: cannot write to %s\n", out.c_str());
    return 1;
  }
  return 0;
}
