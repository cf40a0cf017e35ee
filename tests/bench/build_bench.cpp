// Building Sightline's trees beside Embree's: millions of triangles per second, bytes per triangle.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/thread_group.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/embree_build.h"
#include "tests/bench/machine.h"
#include "tests/bench/statistics.h"

namespace sightline::bench {
namespace {

double clock_ns(clockid_t which) {
  timespec now{};
  clock_gettime(which, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

struct Builder {
  std::string name;
  /// Builds once and returns the bytes per triangle: tree, positions and indices.
  std::function<double()> build;
};

struct Row {
  std::string scene, builder;
  int threads = 1;
  std::uint64_t triangles = 0;
  std::vector<double> seconds;
  double bytes_per_triangle = 0;

  double speed() const { return static_cast<double>(triangles) / spread_of(seconds).median / 1e6; }
};

/// Embree needs a list of indices, Sightline only where they are not 0, 1, 2, ...
double geometry_bytes(const SceneDescription& description, bool all_listed) {
  double bytes = 0;
  for (const auto& mesh : description.meshes) {
    const std::size_t listed = all_listed ? mesh->indices.size() : mesh->indices.listed().size();
    bytes += static_cast<double>(mesh->positions.size() * sizeof(Vec3f) +
                                 listed * sizeof(std::uint32_t));
  }
  return bytes;
}

double tree_bytes(const SceneTree& tree) {
  auto bytes = static_cast<double>(tree.top.arena.used());
  for (const auto& one : tree.trees) bytes += static_cast<double>(one->arena.used());
  return bytes + static_cast<double>(tree.placements.size() * sizeof(Placement));
}

class BuildBench {
 public:
  BuildBench(int threads, int repetitions, std::vector<Row>& rows)
      : threads_(threads), repetitions_(repetitions), rows_(rows) {
    group_.start(threads);
  }

  void run(const BenchScene& scene) {
    const SceneDescription& description = scene.scene->description();
    const auto triangles = static_cast<double>(scene.scene->unique_triangle_count());
    const double geometry = geometry_bytes(description, false);
    const double listed = geometry_bytes(description, true);
    std::optional<EmbreeBuild> medium, high;
    medium.emplace(description, threads_, RTC_BUILD_QUALITY_MEDIUM);
    high.emplace(description, threads_, RTC_BUILD_QUALITY_HIGH);
    std::shared_ptr<const Scene> built;
    const auto ours = [&](TreeQuality quality) {
      SceneDescription copy = description;  // meshes are shared, not copied
      group_.execute([&] {
        if (auto result = Scene::build(std::move(copy), quality)) built = std::move(*result);
      });
      return (tree_bytes(*built->tree()) + geometry) / triangles;
    };
    const std::vector<Builder> builders{
        {"sightline_fast", [&] { return ours(TreeQuality::kFast); }},
        {"sightline_high", [&] { return ours(TreeQuality::kHigh); }},
        {"embree_medium", [&] { return (medium->build() + listed) / triangles; }},
        {"embree_high", [&] { return (high->build() + listed) / triangles; }}};

    // One thread is timed by its CPU time, several by the clock on the wall.
    const clockid_t clock = threads_ == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
    std::vector<Row> rows;
    rows.reserve(builders.size());
    for (const Builder& builder : builders) {
      rows.push_back(
          {scene.name, builder.name, threads_, scene.scene->unique_triangle_count(), {}, 0});
    }
    for (int repetition = -1; repetition < repetitions_; ++repetition) {
      for (std::size_t i = 0; i < builders.size(); ++i) {
        built.reset();
        medium->drop();
        high->drop();
        const double start = clock_ns(clock);
        rows[i].bytes_per_triangle = builders[i].build();
        const double seconds = (clock_ns(clock) - start) * 1e-9;
        if (repetition >= 0) rows[i].seconds.push_back(seconds);
      }
    }
    for (Row& row : rows) {
      const Spread seconds = spread_of(row.seconds);
      std::printf(
          "%-16s %d threads  %-14s %6.2f Mtriangles/s (%.3f s, %.3f to %.3f)  %6.1f bytes "
          "per triangle\n",
          row.scene.c_str(), threads_, row.builder.c_str(), row.speed(), seconds.median,
          seconds.least, seconds.most, row.bytes_per_triangle);
      rows_.push_back(std::move(row));
    }
    std::fflush(stdout);
  }

 private:
  int threads_;
  int repetitions_;
  std::vector<Row>& rows_;
  ThreadGroup group_;
};

const std::vector<std::string> kScenes{"terrain", "scan", "soup", "city"};

const Row* find(const std::vector<Row>& rows, const std::string& scene, const std::string& builder,
                int threads) {
  for (const Row& row : rows) {
    if (row.scene == scene && row.builder == builder && row.threads == threads) return &row;
  }
  return nullptr;
}

std::vector<std::string> floors(const std::vector<Row>& rows) {
  std::vector<std::string> lines;
  char text[200];
  double most_bytes = 0;
  for (int threads : {1, 2}) {
    std::vector<double> ratios;
    for (const std::string& scene : kScenes) {
      const Row* ours = find(rows, scene, "sightline_fast", threads);
      const Row* high = find(rows, scene, "sightline_high", threads);
      const Row* theirs = find(rows, scene, "embree_medium", threads);
      if (ours == nullptr || theirs == nullptr) continue;
      ratios.push_back(ours->speed() / theirs->speed());
      most_bytes = std::max(most_bytes, ours->bytes_per_triangle);
      if (high != nullptr) most_bytes = std::max(most_bytes, high->bytes_per_triangle);
    }
    const double mean = geometric_mean(ratios);
    std::snprintf(text, sizeof text,
                  "floor 6: %.2f (needs 1.20) %s  build speed of the fast preset against Embree "
                  "medium, %d threads, "
                  "mean of %zu scenes",
                  mean, mean >= 1.2 ? "ok" : "short", threads, ratios.size());
    lines.emplace_back(text);
  }
  std::snprintf(text, sizeof text,
                "floor 6: %.1f (needs at most 96) %s  bytes per triangle, positions and indices "
                "included, the most of all scenes and both presets",
                most_bytes, most_bytes > 0 && most_bytes <= 96 ? "ok" : "short");
  lines.emplace_back(text);
  return lines;
}

bool write_report(const std::vector<Row>& rows, int repetitions, const std::string& folder) {
  nlohmann::ordered_json json = {
      {"benchmark", "build"}, {"machine", machine_name()}, {"repetitions", repetitions}};
  std::ofstream csv(folder + "/build.csv"), markdown(folder + "/build.md");
  csv << "scene,builder,threads,triangles,mtriangles_per_second,seconds,least,most,"
         "bytes_per_triangle\n";
  markdown << "# Build: Sightline beside Embree 3.13.5\n\n"
           << machine_name() << ", medians of " << repetitions
           << " interleaved repetitions; one thread by its CPU time, two by the clock on the wall. "
              "Bytes are tree, positions and indices together.\n\n";
  for (const std::string& floor : floors(rows)) markdown << "- " << floor << '\n';
  markdown << "\n| scene | builder | threads | Mtriangles/s | seconds | bytes per triangle "
              "|\n|---|---|--:|--:|--:|--:|\n";
  for (const Row& row : rows) {
    const Spread seconds = spread_of(row.seconds);
    json["rows"].push_back({{"scene", row.scene},
                            {"builder", row.builder},
                            {"threads", row.threads},
                            {"triangles", row.triangles},
                            {"mtriangles_per_second", row.speed()},
                            {"seconds", row.seconds},
                            {"bytes_per_triangle", row.bytes_per_triangle}});
    csv << row.scene << ',' << row.builder << ',' << row.threads << ',' << row.triangles << ','
        << row.speed() << ',' << seconds.median << ',' << seconds.least << ',' << seconds.most
        << ',' << row.bytes_per_triangle << '\n';
    char text[200];
    std::snprintf(text, sizeof text, "| %s | %s | %d | %.2f | %.3f (%.3f to %.3f) | %.1f |\n",
                  row.scene.c_str(), row.builder.c_str(), row.threads, row.speed(), seconds.median,
                  seconds.least, seconds.most, row.bytes_per_triangle);
    markdown << text;
  }
  json["floors"] = floors(rows);
  std::ofstream out(folder + "/build.json");
  out << json.dump(1) << '\n';
  return out.good() && csv.good() && markdown.good();
}

bool measure(int threads, const std::vector<std::string>& names, bool quick, int repetitions,
             std::vector<Row>& rows) {
  std::optional<Pin> pin;
  if (threads == 1) pin.emplace(-1);
  BuildBench bench(threads, repetitions, rows);
  for (const std::string& name : names) {
    const auto scene = load_bench_scene(name, quick ? 4 : 1);
    if (!scene) {
      std::fprintf(stderr, "build_bench: %s: %s\n", name.c_str(), scene.error().message.c_str());
      return false;
    }
    bench.run(*scene);
  }
  return true;
}

/// In a process of its own: what a device of Embree says about threads holds for all of oneTBB, and
/// for good.
bool measure_apart(int threads, const std::vector<std::string>& names, bool quick, int repetitions,
                   std::vector<Row>& rows) {
  const std::string text = in_own_process([&] {
    std::vector<Row> own;
    nlohmann::json json = nlohmann::json::array();
    if (!measure(threads, names, quick, repetitions, own)) return std::string();
    for (const Row& row : own) {
      json.push_back({row.scene, row.builder, row.triangles, row.seconds, row.bytes_per_triangle});
    }
    return json.dump();
  });
  if (text.empty()) return false;
  for (const auto& row : nlohmann::json::parse(text)) {
    rows.push_back({row[0], row[1], threads, row[2], row[3], row[4]});
  }
  return true;
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  using namespace sightline::bench;
  start_again_with_huge_pages(argv);

  std::vector<std::string> wishes = kScenes;
  std::string out;
  int repetitions = 0;
  bool quick = false;
  CLI::App app("Builds trees beside Embree's.");
  app.add_option("--scene", wishes, "terrain, scan, soup, city, ...")->delimiter(',');
  app.add_option("--repetitions", repetitions, "default 5, quick 3");
  app.add_option("--out", out, "write build.json, build.csv and build.md to this folder");
  app.add_flag("--quick", quick, "a quarter of the triangles, 3 repetitions");
  CLI11_PARSE(app, argc, argv);
  if (repetitions <= 0) repetitions = quick ? 3 : 5;

  std::vector<Row> rows;
  for (int threads : {1, 2}) {
    if (!measure_apart(threads, wishes, quick, repetitions, rows)) return 1;
  }
  for (const std::string& line : floors(rows)) std::printf("%s\n", line.c_str());
  if (!out.empty() && !write_report(rows, repetitions, out)) {
    std::fprintf(stderr, "build_bench: cannot write to %s\n", out.c_str());
    return 1;
  }
  return 0;
}
