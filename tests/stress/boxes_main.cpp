/// sightline_stress_boxes: pairs of rays and boxes and of triangles and boxes from a printed seed,
/// judged by rational arithmetic, beside the literature's tests on the same pairs.
///
/// Exit code: 0 if Sightline was never wrong, 1 if it was or a file cannot be written, 2 for a
/// wrong command line.

#include <CLI/CLI.hpp>
#include <atomic>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <mutex>
#include <random>
#include <thread>

#include "tests/stress/box_report.h"

namespace sightline::stress {
namespace {

struct Options {
  std::uint64_t pairs = 1'000'000, triangle_pairs = 200'000, seed = 0;
  unsigned threads = 2;
  std::string json_file, markdown_file;
};

/// A piece of one family, small enough that no thread waits long for the last one.
struct Job {
  BoxTally* result;
  std::function<BoxTally()> judge;
};
constexpr std::uint64_t kPiece = 5000;

/// Shares the pairs among the families by their weights, to the last pair.
template <class Families>
void share_out(const Families& families, std::uint64_t pairs, oracle::Random& seeds,
               std::vector<BoxFamilyResult>& results, std::vector<Job>& jobs) {
  std::uint64_t weight_left = 0, pairs_left = pairs;
  for (const auto& family : families) weight_left += static_cast<std::uint64_t>(family.weight);
  results.reserve(families.size());  // jobs point into it
  for (const auto& family : families) {
    const auto weight = static_cast<std::uint64_t>(family.weight);
    std::uint64_t share =
        pairs_left / weight_left * weight + pairs_left % weight_left * weight / weight_left;
    pairs_left -= share;
    weight_left -= weight;
    BoxTally& tally = results.emplace_back(BoxFamilyResult{std::string(family.name), {}}).tally;
    while (share > 0) {
      const std::uint64_t count = std::min(share, kPiece), seed = seeds.bits();
      jobs.push_back({&tally, [&family, seed, count] { return judge_pairs(family, seed, count); }});
      share -= count;
    }
  }
}

void work(const std::vector<Job>& jobs, unsigned thread_count) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  const auto pull = [&] {
    for (std::size_t i = next.fetch_add(1); i < jobs.size(); i = next.fetch_add(1)) {
      const BoxTally tally = jobs[i].judge();
      const std::scoped_lock lock(mutex);
      for (const std::string& failure : tally.failures) std::cout << "WRONG " << failure << '\n';
      jobs[i].result->add(tally);
    }
  };
  std::vector<std::jthread> threads;
  for (unsigned i = 0; i < thread_count; ++i) threads.emplace_back(pull);
}

bool write(const std::string& file, const std::string& text) {
  if (file.empty()) return true;
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) std::cerr << "sightline_stress_boxes: cannot write " << file << '\n';
  return out.good();
}

int run(const Options& options) {
  std::cout << "seed " << options.seed << std::endl;
  BoxRun run{options.seed, options.threads, 0, {}, {}};
  std::vector<Job> jobs;
  oracle::Random seeds(options.seed);
  share_out(ray_box_families(), options.pairs, seeds, run.rays, jobs);
  share_out(triangle_box_families(), options.triangle_pairs, seeds, run.triangles, jobs);
  work(jobs, options.threads);
  run.cpu_minutes = static_cast<double>(std::clock()) / CLOCKS_PER_SEC / 60;

  const std::string table = markdown(run);
  std::cout << table << '\n';
  const bool written = write(options.markdown_file, table) && write(options.json_file, json(run));
  std::cout << floor_line(run) << std::endl;
  return written && total_of(run.rays).wrong + total_of(run.triangles).wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace sightline::stress

int main(int argc, char** argv) {
  sightline::stress::Options options;
  options.seed = (std::uint64_t{std::random_device{}()} << 32) ^ std::random_device{}();
  CLI::App app("Judges pairs of rays or triangles with boxes by rational arithmetic.");
  app.option_defaults()->take_last();  // scripts/stress.sh names sizes first
  app.add_option("--pairs", options.pairs, "of rays and boxes (default 1,000,000)");
  app.add_option("--triangle-pairs", options.triangle_pairs, "default 200,000");
  app.add_option("--seed", options.seed,
                 "decides every pair; fresh by default, printed in any case");
  app.add_option("--threads", options.threads, "default 2")->check(CLI::Range(1, 64));
  app.add_option("--json", options.json_file, "write the figures to this file");
  app.add_option("--markdown", options.markdown_file, "write the table to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return sightline::stress::run(options);
}
