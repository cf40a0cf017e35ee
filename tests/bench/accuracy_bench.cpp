// Run time against error: everybody's answers judged by the oracle first, then the clock.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/geometry/ray_box.h"
#include "core/trace/kernel/kernel.h"
#include "tests/bench/accuracy_judge.h"
#include "tests/bench/machine.h"
#include "tests/contestants/slab_tests.h"

namespace sightline::bench {
namespace {

struct Options {
  std::string scene = "scan", out, kernel, panel;
  std::size_t rays = 0, pairs = 0;
  std::uint64_t seed = 20250707;
  int repetitions = 0, cpu = -1;
  unsigned smaller = 1;
  bool quick = false;
};

/// The sound forms among the slab tests; the others are there for their mistakes.
constexpr std::size_t kSoundSlabTests = 5;
/// A set is asked this often on one reading of the clock, which would be too coarse for it.
constexpr int kBoxPasses = 4;

/// Calls run(i) for every contestant once per repetition, nobody always behind the same neighbour.
template <class Run>
void interleave(std::size_t contestants, int repetitions, Run run) {
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    for (std::size_t k = 0; k < contestants; ++k) {
      run(repetition % 2 == 0 ? k : contestants - 1 - k);
    }
  }
}

class AccuracyBench {
 public:
  AccuracyBench(Options options, const Kernel& kernel)
      : options_(std::move(options)), kernel_(kernel) {
    result_.machine = machine_name();
    result_.kernel = kernel_.name;
    result_.scene = options_.scene;
    result_.seed = options_.seed;
    result_.quick = options_.quick;
    result_.repetitions = options_.repetitions;
  }

  /// False when the scene cannot be had, or is none that textbooks can trace.
  bool run_scene() {
    const auto scene = load_bench_scene(options_.scene, options_.smaller);
    if (!scene) {
      std::fprintf(stderr, "accuracy_bench: %s\n", scene.error().message.c_str());
      return false;
    }
    result_.triangles = scene->scene->unique_triangle_count();
    Contestants contestants;
    contestants.push_back(make_sightline(kOurs, result_.kernel, *scene));
    contestants.push_back(make_unrounded(*scene));
    for (const std::string& name : textbook_names()) {
      contestants.push_back(make_textbook(name, *scene));
    }
    for (const auto& contestant : contestants) {
      if (contestant == nullptr) {
        std::fprintf(stderr, "accuracy_bench: textbooks cannot trace %s\n", options_.scene.c_str());
        return false;
      }
    }
    for (auto& embree : make_embree({"embree1", "embree1_robust"}, *scene)) {
      contestants.push_back(std::move(embree));
    }
    for (const auto& contestant : contestants) {
      result_.contestants["scene"].push_back(contestant->name());
    }
    const SceneJudge judge(*scene->scene);
    for (const AccuracyRays& rays : make_accuracy_rays(*scene, options_.rays, options_.seed)) {
      run_rays(rays, judge, contestants);
    }
    return true;
  }

  void run_boxes() {
    BoxContestants contestants;
    const Kernel kernel = kernel_;
    for (const auto& [name, detail] :
         {std::pair{kOurs, RayBoxDetail::kT}, std::pair{kOursAll, RayBoxDetail::kAll}}) {
      contestants.push_back(
          {name, [kernel, detail = detail](const AccuracyPairs& pairs, BoxAnswers& answers) {
             answers.batch.resize(pairs.rays.size(), detail);
             kernel.ray_boxes(pairs.ray_batch, pairs.box_batch, BoxPairing::kEach, 0,
                              pairs.rays.size(), answers.batch);
           }});
    }
    contestants.push_back({kOursSingle, [](const AccuracyPairs& pairs, BoxAnswers& answers) {
                             for (std::size_t i = 0; i < pairs.rays.size(); ++i) {
                               const Ray& ray = pairs.rays[i];
                               const RayBoxAnswer answer = ray_box(
                                   ray.origin, ray.direction, ray.tmin, ray.tmax, pairs.boxes[i]);
                               answers.hit[i] = answer.outcome == RayBoxOutcome::kHit ? 1 : 0;
                               answers.t[i] = answer.t;
                             }
                           }});
    for (const auto& slab_test : contestants::slab_tests().first(kSoundSlabTests)) {
      const auto test = slab_test.test;
      contestants.push_back(
          {std::string(slab_test.name), [test](const AccuracyPairs& pairs, BoxAnswers& answers) {
             for (std::size_t i = 0; i < pairs.rays.size(); ++i) {
               const auto answer = test(pairs.rays[i], pairs.boxes[i]);
               answers.hit[i] = answer.hit ? 1 : 0;
               answers.t[i] = answer.t;
             }
           }});
    }
    for (const BoxContestant& contestant : contestants) {
      result_.contestants["box"].push_back(contestant.name);
    }
    for (const AccuracyPairs& pairs : make_accuracy_pairs(options_.pairs, options_.seed)) {
      run_pairs(pairs, contestants);
    }
  }

  AccuracyResult& result() { return result_; }

 private:
  void run_rays(const AccuracyRays& rays, const SceneJudge& judge, const Contestants& contestants) {
    AccuracyCell cell{"scene", rays.group, rays.set.name, rays.set.size(), {}};
    std::vector<Answers> answers(contestants.size());
    const auto ask = [&](std::size_t i) { contestants[i]->closest(rays.set, answers[i]); };
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      answers[i].resize(rays.set.size());
      ask(i);
    }
    judge_rays(judge, rays.set, contestants, answers, cell);
    const Pin pin(options_.cpu);
    result_.cpu = pin.cpu();
    for (std::size_t i = 0; i < contestants.size(); ++i) ask(i);  // warm again
    interleave(contestants.size(), options_.repetitions, [&](std::size_t i) {
      const double start = thread_time_ns();
      ask(i);
      const double time = thread_time_ns() - start;
      cell.entries[contestants[i]->name()].times.push_back(time / static_cast<double>(cell.count));
    });
    finish(std::move(cell));
  }

  void run_pairs(const AccuracyPairs& pairs, const BoxContestants& contestants) {
    AccuracyCell cell{"box", pairs.group, pairs.family, pairs.rays.size(), {}};
    std::vector<BoxAnswers> answers(contestants.size());
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      answers[i].hit.resize(cell.count);
      answers[i].t.resize(cell.count);
      contestants[i].run(pairs, answers[i]);
    }
    judge_pairs(pairs, contestants, answers, cell);
    const Pin pin(options_.cpu);
    result_.cpu = pin.cpu();
    for (std::size_t i = 0; i < contestants.size(); ++i) contestants[i].run(pairs, answers[i]);
    interleave(contestants.size(), options_.repetitions, [&](std::size_t i) {
      const double start = thread_time_ns();
      for (int pass = 0; pass < kBoxPasses; ++pass) contestants[i].run(pairs, answers[i]);
      const double time = thread_time_ns() - start;
      cell.entries[contestants[i].name].times.push_back(
          time / (kBoxPasses * static_cast<double>(cell.count)));
    });
    finish(std::move(cell));
  }

  void finish(AccuracyCell cell) {
    std::printf("%s %s %s, %zu judged\n", cell.panel.c_str(), cell.group.c_str(),
                cell.family.c_str(), cell.count);
    for (const std::string& name : result_.contestants[cell.panel]) {
      const AccuracyEntry& entry = cell.entries[name];
      const Spread time = spread_of(entry.times), error = spread_of(entry.t_errors);
      std::printf(
          "  %-26s %8.1f ns (%.1f to %.1f)  wrong %zu (%zu false hits, %zu false misses)  "
          "t %.3g median, %.3g worst ulp\n",
          name.c_str(), time.median, time.least, time.most, entry.wrong(), entry.false_hits,
          entry.false_misses, error.median, error.most);
    }
    std::fflush(stdout);
    result_.cells.push_back(std::move(cell));
  }

  Options options_;
  Kernel kernel_;
  AccuracyResult result_;
};

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  using namespace sightline::bench;
  using sightline::Kernel, sightline::supported_kernels;
  start_again_with_huge_pages(argv);

  Options options;
  CLI::App app("Run time against error: Sightline, Embree and the literature's tests.");
  app.add_option("--scene", options.scene, "one mesh, placed once (default scan)");
  app.add_option("--rays", options.rays,
                 "of each hard family; four times as many of each ordinary "
                 "kind (default 65536, quick 4096)");
  app.add_option("--pairs", options.pairs, "the same of rays and boxes");
  app.add_option("--seed", options.seed, "of the hard rays and of the pairs");
  app.add_option("--repetitions", options.repetitions, "default 9, quick 5");
  app.add_option("--cpu", options.cpu, "pin to this CPU (default: the last one)");
  app.add_option("--smaller", options.smaller, "divide the generated triangle counts");
  app.add_option("--kernel", options.kernel, "of Sightline (default: the best)");
  app.add_option("--panel", options.panel, "scene or box (default: both)")
      ->check(CLI::IsMember({"scene", "box"}));
  app.add_option("--out", options.out, "write accuracy.json, .csv and .md to this folder");
  app.add_flag("--quick", options.quick, "fewer rays and repetitions");
  CLI11_PARSE(app, argc, argv);
  if (options.repetitions <= 0) options.repetitions = options.quick ? 5 : 9;
  if (options.rays == 0) options.rays = options.quick ? 4096 : 65536;
  if (options.pairs == 0) options.pairs = options.quick ? 4096 : 65536;
  if (options.smaller == 0) options.smaller = 1;

  Kernel chosen = supported_kernels().front();
  for (const Kernel& kernel : supported_kernels()) {
    if (kernel.name == options.kernel) chosen = kernel;
  }
  if (!options.kernel.empty() && chosen.name != options.kernel) {
    std::fprintf(stderr, "accuracy_bench: no kernel %s here\n", options.kernel.c_str());
    return 2;
  }
  AccuracyBench bench(options, chosen);
  std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
  if (options.panel != "box" && !bench.run_scene()) return 1;
  if (options.panel != "scene") bench.run_boxes();
  for (const std::string& line : accuracy_floors(bench.result())) std::printf("%s\n", line.c_str());
  if (!options.out.empty() && !write_accuracy_report(bench.result(), options.out)) {
    std::fprintf(stderr, "accuracy_bench: cannot write to %s\n", options.out.c_str());
    return 1;
  }
  for (const AccuracyCell& cell : bench.result().cells) {
    const auto ours = cell.entries.find(kOurs);
    if (ours == cell.entries.end() || ours->second.wrong() > 0) return 1;
  }
  return 0;
}
