// Sightline beside Embree in one process: the same answers first, then the clock.

#include <fnmatch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "core/trace/kernel/kernel.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/contestant.h"
#include "tests/bench/machine.h"
#include "tests/bench/trace_result.h"

namespace sightline::bench {
namespace {

struct Options {
  std::vector<std::string> scenes, rays, queries, contestants;
  int repetitions = 0, cpu = -1;
  unsigned smaller = 1;
  std::size_t judge = 256;
  bool quick = false, work = false;
  std::string kernel, out;
};

/// Whether a filter is empty or has a shell pattern that fits.
bool wanted(const std::vector<std::string>& patterns, const std::string& name) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(), [&](const auto& p) {
           return fnmatch(p.c_str(), name.c_str(), 0) == 0;
         });
}

std::vector<std::string> keep(const std::vector<std::string>& names,
                              const std::vector<std::string>& patterns) {
  std::vector<std::string> kept;
  for (const std::string& name : names) {
    if (wanted(patterns, name)) kept.push_back(name);
  }
  return kept;
}

class TraceBench {
 public:
  explicit TraceBench(Options options) : options_(std::move(options)) {
    result_.machine = machine_name();
    result_.kernel =
        options_.kernel.empty() ? std::string(supported_kernels().front().name) : options_.kernel;
    result_.quick = options_.quick;
    result_.repetitions = options_.repetitions;
    auto all = {sightline_names(), embree_names(), textbook_names()};
    for (const auto& names : all) {
      // Textbooks run only when they are named.
      if (options_.contestants.empty() && names == textbook_names()) continue;
      for (const std::string& name : keep(names, options_.contestants)) {
        // So do other kernels and other instruction sets of Embree.
        if (!options_.contestants.empty() || name.find('@') == std::string::npos)
          result_.contestants.push_back(name);
      }
    }
  }

  /// False when a scene cannot be loaded.
  bool run() {
    for (const std::string& name : keep(scene_names(), options_.scenes)) {
      if (!run_scene(name)) return false;
    }
    const PageUse use = page_use();
    result_.huge_kib = std::max(result_.huge_kib, use.huge_kib);
    result_.resident_kib = std::max(result_.resident_kib, use.resident_kib);
    return true;
  }
  const TraceResult& result() const { return result_; }

 private:
  using Contestants = std::vector<std::unique_ptr<Contestant>>;

  bool run_scene(const std::string& name) {
    const auto scene = load_bench_scene(name, options_.smaller);
    if (!scene) {
      std::fprintf(stderr, "trace_bench: %s: %s\n", name.c_str(), scene.error().message.c_str());
      return false;
    }
    const Scene& built = *scene->scene;
    result_.scenes.push_back({name, built.unique_triangle_count(), built.instanced_triangle_count(),
                              built.description().instances.size(), scene->build_seconds});
    std::printf("# %s: %llu triangles, %llu placed, built in %.2f s\n", name.c_str(),
                static_cast<unsigned long long>(built.unique_triangle_count()),
                static_cast<unsigned long long>(built.instanced_triangle_count()),
                scene->build_seconds);

    Contestants contestants;
    for (const std::string& wish : result_.contestants) {
      if (auto ours = make_sightline(wish, options_.kernel, *scene)) {
        contestants.push_back(std::move(ours));
      }
    }
    for (const std::string& wish : result_.contestants) {
      if (auto theirs = make_textbook(wish, *scene)) contestants.push_back(std::move(theirs));
    }
    for (auto& theirs : make_embree(result_.contestants, *scene)) {
      contestants.push_back(std::move(theirs));
    }
    std::unique_ptr<SceneJudge> judge;
    if (options_.judge > 0) judge = std::make_unique<SceneJudge>(built);

    const Pin pin(options_.cpu);
    result_.cpu = pin.cpu();
    const RayCounts counts = options_.quick ? RayCounts::quick() : RayCounts::full();
    for (const RaySet& rays : make_ray_sets(*scene, counts)) {
      if (wanted(options_.rays, rays.name) && rays.size() > 0) {
        run_rays(*scene, rays, contestants, judge.get());
      }
    }
    const PageUse use = page_use();
    result_.huge_kib = std::max(result_.huge_kib, use.huge_kib);
    result_.resident_kib = std::max(result_.resident_kib, use.resident_kib);
    return true;
  }

  void run_rays(const BenchScene& scene, const RaySet& rays, const Contestants& contestants,
                const SceneJudge* judge) {
    std::vector<Answers> answers(contestants.size());
    for (Answers& slots : answers) slots.resize(rays.size());
    AnswerCheck& check = result_.checks[scene.name + " " + rays.name];
    for (const char* query : {"closest", "any"}) {
      if (!wanted(options_.queries, query)) continue;
      const bool closest = std::string_view(query) == "closest";
      TraceCell cell{scene.name, rays.name, query, rays.size(), {}};
      const auto run = [&](std::size_t i) {
        if (closest) {
          contestants[i]->closest(rays, answers[i]);
        } else if (contestants[i]->knows_any()) {
          contestants[i]->any(rays, answers[i]);
        }
      };
      // The pass that warms caches up is also the one whose answers are compared.
      for (std::size_t i = 0; i < contestants.size(); ++i) run(i);
      compare(closest, rays, contestants, answers, judge, check);
      for (int repetition = 0; repetition < options_.repetitions; ++repetition) {
        for (std::size_t k = 0; k < contestants.size(); ++k) {
          // Nobody always comes after the same neighbour's cache.
          const std::size_t i = repetition % 2 == 0 ? k : contestants.size() - 1 - k;
          if (!closest && !contestants[i]->knows_any()) continue;
          const double start = thread_time_ns();
          run(i);
          const double time = thread_time_ns() - start;
          cell.times[contestants[i]->name()].push_back(time / static_cast<double>(rays.size()));
        }
      }
      print(cell);
      result_.cells.push_back(std::move(cell));
    }
    for (const auto& contestant : contestants) {
      if (!contestant->exact()) continue;
      const std::string work = contestant->explain(rays);
      result_.work[scene.name + " " + rays.name] = work;
      if (options_.work) std::printf("  %s\n", work.c_str());
      break;
    }
    std::printf(
        "  answers: %zu mismatches of %zu, %zu judged, Sightline wrong %zu, inconsistent "
        "%zu, Embree wrong %zu, ties %zu %s\n",
        check.mismatches, check.rays, check.judged, check.sightline_wrong, check.inconsistent,
        check.embree_wrong, check.ties, check.example.c_str());
    std::fflush(stdout);
  }

  void compare(bool closest, const RaySet& rays, const Contestants& contestants,
               const std::vector<Answers>& answers, const SceneJudge* judge,
               AnswerCheck& check) const {
    const Answers* ours = nullptr;
    const Answers* theirs = nullptr;
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      if (contestants[i]->exact() && ours == nullptr) ours = &answers[i];
      if (!contestants[i]->float64() && theirs == nullptr) theirs = &answers[i];
    }
    if (ours == nullptr) return;
    if (closest) check_closest(rays, *ours, theirs, judge, options_.judge, check);
    const bool knows_closest = wanted(options_.queries, "closest");
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      if (!contestants[i]->exact()) continue;
      if (closest) {
        check_same(contestants[i]->name(), *ours, answers[i], check);
      } else if (knows_closest) {
        check_any(contestants[i]->name(), *ours, answers[i], &answers[i] == ours ? theirs : nullptr,
                  check);
      }
    }
  }

  void print(const TraceCell& cell) const {
    std::printf("%s %s %s, %zu rays\n", cell.scene.c_str(), cell.rays.c_str(), cell.query.c_str(),
                cell.count);
    for (const std::string& name : result_.contestants) {
      if (!cell.has(name)) continue;
      const Spread time = spread_of(cell.times.at(name));
      std::printf("  %-30s %8.1f ns (%.1f to %.1f)", name.c_str(), time.median, time.least,
                  time.most);
      if (cell.has("embree1")) {
        const Spread ratio = speed_ratio(cell.times.at("embree1"), cell.times.at(name));
        std::printf("  x%.2f (%.2f to %.2f)", ratio.median, ratio.least, ratio.most);
      }
      std::printf("\n");
    }
    std::fflush(stdout);
  }

  Options options_;
  TraceResult result_;
};

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  using namespace sightline::bench;
  start_again_with_huge_pages(argv);

  Options options;
  CLI::App app("Times Sightline beside Embree: same scenes, same rays, one pinned thread.");
  app.add_option("--scene", options.scenes, "names or shell patterns")->delimiter(',');
  app.add_option("--rays", options.rays, "camera, lidar, ao, incoherent")->delimiter(',');
  app.add_option("--query", options.queries, "closest, any")->delimiter(',');
  app.add_option("--contestant", options.contestants, "names or shell patterns")->delimiter(',');
  app.add_option("--repetitions", options.repetitions, "default 5, quick 3");
  app.add_option("--judge", options.judge, "rays per cell that the oracle judges; 0: none");
  app.add_option("--kernel", options.kernel, "force Sightline's instruction set");
  app.add_option("--cpu", options.cpu, "pin to this CPU (default: the last one)");
  app.add_option("--smaller", options.smaller, "divide the generated triangle counts");
  app.add_option("--out", options.out, "write trace.json, trace.csv and trace.md to this folder");
  app.add_flag("--quick", options.quick, "fewer rays, 3 repetitions");
  app.add_flag("--work", options.work, "print what Sightline did per ray");
  CLI11_PARSE(app, argc, argv);
  if (options.repetitions <= 0) options.repetitions = options.quick ? 3 : 5;
  if (options.smaller == 0) options.smaller = 1;

  TraceBench bench(options);
  if (!bench.run()) return 1;
  for (const std::string& line : trace_floors(bench.result())) std::printf("%s\n", line.c_str());
  if (!options.out.empty() && !write_trace_report(bench.result(), options.out)) {
    std::fprintf(stderr, "trace_bench: cannot write to %s\n", options.out.c_str());
    return 1;
  }
  for (const auto& [name, check] : bench.result().checks) {
    if (check.sightline_wrong + check.inconsistent > 0) return 1;
  }
  return 0;
}
