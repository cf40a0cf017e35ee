// How time and memory grow with the number of triangles and of instances.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/demo/demo.h"
#include "core/trace/kernel.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/contestant.h"
#include "tests/bench/machine.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {
namespace {

struct Row {
  std::string subject, rays;  ///< "triangles" or "instances"; the rays' name
  std::uint64_t size = 0;     ///< how many of the subject
  double ns_per_ray = 0, least = 0, most = 0;
  double warm_ns_per_ray = 0;  ///< of rays whose nodes and blocks are in the caches already
  double nodes_per_ray = 0, blocks_per_ray = 0;
  double build_seconds = 0;
  double tree_bytes = 0;
  double peak_mib = 0;  ///< of the whole process, making the scene included
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Row, subject, rays, size, ns_per_ray, least, most,
                                   warm_ns_per_ray, nodes_per_ray, blocks_per_ray, build_seconds,
                                   tree_bytes, peak_mib)

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
/// twice, the second time counted: the work alone, and what batches of this size cost more.
double warm_ns_per_ray(const Kernel& kernel, const Scene& scene, const RayBatch& rays,
                       HitBatch& hits) {
  constexpr std::size_t kBatch = 512;
  TraceCounts counts;
  double sum = 0;
  for (std::size_t begin = 0; begin < rays.size(); begin += kBatch) {
    const std::size_t end = std::min(rays.size(), begin + kBatch);
    kernel.closest(scene, rays, begin, end, hits, counts);
    const double before = thread_time_ns();
    kernel.closest(scene, rays, begin, end, hits, counts);
    sum += thread_time_ns() - before;
  }
  return sum / static_cast<double>(rays.size());
}

std::vector<Row> measure(const std::string& subject, std::uint64_t size, int repetitions) {
  const auto count = static_cast<std::uint32_t>(size);
  const bool triangles = subject == "triangles";
  SceneDescription description =
      description_of(triangles ? demo::terrain(count) : demo::instances(count, 2'000));
  const double start = wall_time_seconds();
  auto built = Scene::build(std::move(description));
  const double build_seconds = wall_time_seconds() - start;
  if (!built) return {};
  const BenchScene scene{subject, triangles ? Viewpoints::kGround : Viewpoints::kWithin,
                         std::move(*built), build_seconds};
  const std::shared_ptr<const SceneTree> trees = scene.scene->tree();
  double tree_bytes = static_cast<double>(trees->top.arena.used());
  for (const auto& tree : trees->trees) {
    tree_bytes += static_cast<double>(tree->arena.used());
  }

  const Pin pin(-1);
  const Kernel kernel = supported_kernels().front();
  std::vector<Row> rows;
  for (const RaySet& rays : make_ray_sets(scene, RayCounts::quick())) {
    HitBatch hits;
    hits.resize(rays.size());
    std::vector<double> times, warm_times;
    TraceCounts counts;
    for (int repetition = -1; repetition < repetitions; ++repetition) {
      counts = {};
      const double before = thread_time_ns();
      kernel.closest(*scene.scene, rays.rays, 0, rays.size(), hits, counts);
      const double time = (thread_time_ns() - before) / static_cast<double>(rays.size());
      const double warm = warm_ns_per_ray(kernel, *scene.scene, rays.rays, hits);
      if (repetition < 0) continue;
      times.push_back(time);
      warm_times.push_back(warm);
    }
    const Spread time = spread_of(times);
    const auto per_ray = [&](std::uint64_t n) {
      return static_cast<double>(n) / static_cast<double>(rays.size());
    };
    rows.push_back({subject, rays.name, size, time.median, time.least, time.most,
                    spread_of(warm_times).median, per_ray(counts.nodes), per_ray(counts.blocks),
                    build_seconds, tree_bytes, peak_mib()});
  }
  return rows;
}

/// In a process of its own, so that the peak of memory is that of this size.
std::vector<Row> measure_apart(const std::string& subject, std::uint64_t size, int repetitions) {
  const std::string text =
      in_own_process([&] { return nlohmann::json(measure(subject, size, repetitions)).dump(); });
  if (text.empty()) return {};
  return nlohmann::json::parse(text).get<std::vector<Row>>();
}

/// Least squares of value = a + b log2(size).
struct Fit {
  double a = 0, b = 0;
};
template <class Value>
Fit fit_logarithm(const std::vector<Row>& rows, Value value) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Row& row : rows) {
    const double x = std::log2(static_cast<double>(row.size)), y = value(row);
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double b = n < 2 ? 0 : (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {n == 0 ? 0 : (sy - b * sx) / n, b};
}

std::vector<Row> pick(const std::vector<Row>& rows, const std::string& subject,
                      const std::string& rays) {
  std::vector<Row> picked;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(picked),
               [&](const Row& row) { return row.subject == subject && row.rays == rays; });
  return picked;
}

const std::vector<std::string> kRays{"camera", "lidar", "ao", "incoherent"};

std::vector<std::string> floors(const std::vector<Row>& rows) {
  std::vector<std::string> lines;
  char text[240];
  const Row* largest = nullptr;
  for (const Row& row : rows) {
    if (row.subject == "triangles" && (largest == nullptr || row.size > largest->size)) {
      largest = &row;
    }
  }
  if (largest != nullptr) {
    const bool ok = largest->size >= 16'000'000 && largest->peak_mib <= 4096;
    std::snprintf(text, sizeof text,
                  "floor 7: %.2f (needs at most 4) %s  GiB at the peak with %.1f M triangles, "
                  "making the scene included",
                  largest->peak_mib / 1024, ok ? "ok" : "short",
                  static_cast<double>(largest->size) / 1e6);
    lines.emplace_back(text);
  }
  // If time were proportional to the logarithm of the size these were 1.
  std::vector<double> time_growth, warm_growth, node_growth;
  for (const std::string& rays : kRays) {
    const std::vector<Row> line = pick(rows, "triangles", rays);
    if (line.size() < 2) continue;
    const Row& first = line.front();
    const Row& last = line.back();
    const double logs =
        std::log2(static_cast<double>(last.size)) / std::log2(static_cast<double>(first.size));
    time_growth.push_back(last.ns_per_ray / first.ns_per_ray / logs);
    warm_growth.push_back(last.warm_ns_per_ray / first.warm_ns_per_ray / logs);
    node_growth.push_back(last.nodes_per_ray / first.nodes_per_ray / logs);
  }
  if (!time_growth.empty()) {
    const double growth = geometric_mean(time_growth);
    std::snprintf(text, sizeof text,
                  "floor 7: %.2f (needs at most 1) %s  growth of ns per ray from the smallest to "
                  "the largest terrain over that of the logarithm, mean of %zu kinds of rays "
                  "(warm: %.2f, nodes per ray: %.2f)",
                  growth, growth <= 1 ? "ok" : "short", time_growth.size(),
                  geometric_mean(warm_growth), geometric_mean(node_growth));
    lines.emplace_back(text);
  }
  return lines;
}

bool write_report(const std::vector<Row>& rows, const std::string& folder) {
  nlohmann::ordered_json json = {{"benchmark", "scale"}, {"machine", machine_name()}};
  json["rows"] = nlohmann::json(rows);
  std::ofstream csv(folder + "/scale.csv"), markdown(folder + "/scale.md");
  csv << "subject,rays,size,ns_per_ray,least,most,warm_ns_per_ray,nodes_per_ray,blocks_per_ray,"
         "build_seconds,"
         "tree_bytes,peak_mib\n";
  for (const Row& row : rows) {
    csv << row.subject << ',' << row.rays << ',' << row.size << ',' << row.ns_per_ray << ','
        << row.least << ',' << row.most << ',' << row.warm_ns_per_ray << ',' << row.nodes_per_ray
        << ',' << row.blocks_per_ray << ',' << row.build_seconds << ',' << row.tree_bytes << ','
        << row.peak_mib << '\n';
  }
  markdown << "# Scale: how time and memory grow\n\n![Scale](scale.png)\n\n"
           << machine_name()
           << "; closest hit, one pinned thread, its own CPU time; every size in a process of its "
              "own. Triangles: one terrain. Instances: copies of a ball of 2,000 triangles. Nodes "
              "and blocks are what a ray visits: they do not know caches, the time does. Warm: "
              "batches of "
              "512 rays, each traced twice, the second time counted.\n\n";
  for (const std::string& floor : floors(rows)) markdown << "- " << floor << '\n';
  for (const char* subject : {"triangles", "instances"}) {
    markdown << "\n## " << subject << "\n\nFitted: a + b log2(size).\n\n"
             << "| rays | ns: a | ns: b | nodes: a | nodes: b |\n|---|--:|--:|--:|--:|\n";
    for (const std::string& rays : kRays) {
      const std::vector<Row> line = pick(rows, subject, rays);
      const Fit ns = fit_logarithm(line, [](const Row& r) { return r.ns_per_ray; });
      const Fit nodes = fit_logarithm(line, [](const Row& r) { return r.nodes_per_ray; });
      json["fits"].push_back({{"subject", subject},
                              {"rays", rays},
                              {"ns_a", ns.a},
                              {"ns_b", ns.b},
                              {"nodes_a", nodes.a},
                              {"nodes_b", nodes.b}});
      char text[160];
      std::snprintf(text, sizeof text, "| %s | %.1f | %.2f | %.2f | %.3f |\n", rays.c_str(), ns.a,
                    ns.b, nodes.a, nodes.b);
      markdown << text;
    }
    markdown
        << "\n| " << subject
        << " | rays | ns per ray | ns warm | nodes | blocks | build, s | tree, MiB | peak, MiB "
           "|\n|--:|---|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const Row& row : rows) {
      if (row.subject != subject) continue;
      char text[240];
      std::snprintf(
          text, sizeof text,
          "| %llu | %s | %.0f (%.0f to %.0f) | %.0f | %.1f | %.1f | %.2f | %.1f | %.0f |\n",
          static_cast<unsigned long long>(row.size), row.rays.c_str(), row.ns_per_ray, row.least,
          row.most, row.warm_ns_per_ray, row.nodes_per_ray, row.blocks_per_ray, row.build_seconds,
          row.tree_bytes / (1 << 20), row.peak_mib);
      markdown << text;
    }
  }
  json["floors"] = floors(rows);
  std::ofstream out(folder + "/scale.json");
  out << json.dump(1) << '\n';
  return out.good() && csv.good() && markdown.good();
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
  std::vector<Row> rows;
  for (const auto& [subject, size] : sizes) {
    const std::vector<Row> more = measure_apart(subject, size, repetitions);
    if (more.empty()) {
      std::fprintf(stderr, "scale_bench: %llu %s could not be measured\n",
                   static_cast<unsigned long long>(size), subject.c_str());
      return 1;
    }
    std::printf("%9llu %-9s built in %.2f s, tree %.1f MiB, peak %.0f MiB;",
                static_cast<unsigned long long>(size), subject.c_str(), more[0].build_seconds,
                more[0].tree_bytes / (1 << 20), more.back().peak_mib);
    for (const Row& row : more) std::printf(" %s %.0f ns", row.rays.c_str(), row.ns_per_ray);
    std::printf("\n");
    std::fflush(stdout);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  for (const std::string& line : floors(rows)) std::printf("%s\n", line.c_str());
  if (!out.empty() && !write_report(rows, out)) {
    std::fprintf(stderr, "scale_bench: cannot write to %s\n", out.c_str());
    return 1;
  }
  return 0;
}
