/// sightline_stress: families of hard rays with printed seeds, judged by rational arithmetic.
///
///   sightline_stress [--minutes N | --rounds N] [--rays N] [--seed S] [--family NAME]...
///                    [--without NAME]... [--kernel NAME] [--threads N] [--json FILE]
///                    [--markdown FILE] [--list] [--log] [--apart] [--trial S [--shrink]]
///
/// --minutes N    rounds of all families until the time is up (at least one round)
/// --rounds N     so many rounds (default 1)
/// --rays N       rays of a family in a round (default 4000)
/// --seed S       default: fresh; printed in any case. Seed, family and round decide the rays.
/// --trial S      one trial with exactly this seed, as a failure names it; needs --family and the
///                same --rays
/// --log          names every trial on standard error as it starts, so that a crash can be repeated
/// --apart        every placement is entered on its own, none share a tree of the world
/// --shrink       with --trial: the smallest scene and one ray that are still wrong, or still crash
/// --kernel NAME  default: every kernel of this machine in turn
/// --threads N    families at the same time (default 2)
///
/// Exit code: 0 if Sightline was never wrong, 1 if it was, 2 for a wrong command line.

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <mutex>
#include <optional>
#include <random>
#include <string_view>
#include <thread>

#include "tests/stress/report.h"
#include "tests/stress/shrink.h"
#include "tests/stress/trial.h"

namespace sightline::stress {
namespace {

using Clock = std::chrono::steady_clock;

struct Flags {
  double minutes = 0;
  std::size_t rounds = 0;
  std::size_t rays = 4000;
  std::uint64_t seed = 0;
  std::optional<std::uint64_t> trial;
  std::vector<std::string> families, without;
  std::string kernel, json_file, markdown_file;
  std::size_t threads = 2;
  bool list = false, shrink = false, log = false;
  Joining joining = Joining::kMeasured;
};

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

std::optional<Flags> parse_flags(const std::vector<std::string>& words) {
  Flags flags;
  flags.seed = (std::uint64_t{std::random_device{}()} << 32) ^ std::random_device{}();
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& name = words[i];
    if (name == "--list") {
      flags.list = true;
      continue;
    }
    if (name == "--shrink") {
      flags.shrink = true;
      continue;
    }
    if (name == "--log") {
      flags.log = true;
      continue;
    }
    if (name == "--apart") {
      flags.joining = Joining::kNever;
      continue;
    }
    if (i + 1 == words.size()) return std::nullopt;
    const std::string& value = words[++i];
    bool good = true;
    if (name == "--minutes") {
      good = parse(value, flags.minutes);
    } else if (name == "--rounds") {
      good = parse(value, flags.rounds);
    } else if (name == "--rays") {
      good = parse(value, flags.rays) && flags.rays > 0;
    } else if (name == "--seed") {
      good = parse(value, flags.seed);
    } else if (name == "--trial") {
      std::uint64_t seed = 0;
      good = parse(value, seed);
      flags.trial = seed;
    } else if (name == "--threads") {
      good = parse(value, flags.threads) && flags.threads > 0 && flags.threads <= 64;
    } else if (name == "--family") {
      flags.families.push_back(value);
    } else if (name == "--without") {
      flags.without.push_back(value);
    } else if (name == "--kernel") {
      flags.kernel = value;
    } else if (name == "--json") {
      flags.json_file = value;
    } else if (name == "--markdown") {
      flags.markdown_file = value;
    } else {
      good = false;
    }
    if (!good) return std::nullopt;
  }
  return flags;
}

/// Families in turn, each on one of several threads, until rounds or time are used up.
class Run {
 public:
  Run(const Flags& flags, std::vector<Family> families)
      : flags_(flags), kernels_(Engine::kernels()), start_(Clock::now()) {
    if (!flags.kernel.empty()) kernels_ = {flags.kernel};
    for (Family& family : families) results_.push_back({std::move(family), {}});
  }

  void work() {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < flags_.threads; ++i) threads.emplace_back([this] { pull(); });
  }

  const std::vector<FamilyResult>& results() const { return results_; }
  RunFacts facts() const { return {flags_.seed, minutes(), kernels_}; }

 private:
  double minutes() const {
    return std::chrono::duration<double, std::ratio<60>>(Clock::now() - start_).count();
  }
  bool time_is_up() const { return flags_.minutes > 0 && minutes() >= flags_.minutes; }

  void log(const std::string& family, std::uint64_t seed) {
    const std::scoped_lock lock(mutex_);
    std::cerr << "trial --family " << family << " --trial " << seed << " --rays " << flags_.rays
              << std::endl;
  }

  void pull() {
    for (;;) {
      const std::size_t job = next_.fetch_add(1);
      const std::size_t round = job / results_.size();
      if (flags_.minutes > 0 ? round > 0 && time_is_up()
                             : round >= std::max<std::size_t>(1, flags_.rounds))
        return;
      FamilyResult& result = results_[job % results_.size()];
      // The job's own seed: a failure names it.
      Random mixer(flags_.seed ^ (0x9e3779b97f4a7c15ull * (job + 1)));
      const std::uint64_t seed = flags_.trial ? *flags_.trial : mixer.bits();
      if (flags_.log) log(result.family.name, seed);
      TrialOptions options;
      options.rays = flags_.rays;
      options.kernel = kernels_[round % kernels_.size()];
      options.joining = flags_.joining;
      options.threads = round % 3 == 2 ? 2 : 1;
      const FamilyTally tally = run_trial(result.family, seed, options);
      const std::scoped_lock lock(mutex_);
      for (const std::string& text : tally.failures) std::cout << "WRONG " << text << std::endl;
      result.tally.add(tally);
    }
  }

  Flags flags_;
  std::vector<std::string> kernels_;
  std::vector<FamilyResult> results_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  Clock::time_point start_;
};

int main_with(const std::vector<std::string>& words) {
  const auto flags = parse_flags(words);
  if (!flags) {
    std::cerr << "sightline_stress: wrong command line; see the head of tests/stress/main.cpp\n";
    return 2;
  }
  std::vector<Family> chosen;
  for (Family& family : families()) {
    const auto named = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), family.name) != names.end();
    };
    if ((flags->families.empty() || named(flags->families)) && !named(flags->without))
      chosen.push_back(std::move(family));
  }
  if (flags->list) {
    for (const Family& family : chosen) std::cout << family.name << ": " << family.what << "\n";
    return 0;
  }
  if (chosen.empty() || (flags->trial && chosen.size() != 1)) {
    std::cerr << "sightline_stress: no such family (see --list)\n";
    return 2;
  }
  if (flags->trial && flags->shrink) {
    Random random(*flags->trial);
    const auto smallest =
        shrink(chosen[0].make(random, flags->rays), flags->kernel, flags->joining);
    std::cout << (smallest ? describe(*smallest) : "every ray is answered rightly\n");
    return smallest ? 1 : 0;
  }
  std::cout << "seed " << flags->seed << ", " << chosen.size() << " families" << std::endl;
  Run run(*flags, std::move(chosen));
  run.work();

  const std::string table = markdown(run.results(), run.facts());
  std::cout << table;
  if (!flags->markdown_file.empty()) std::ofstream(flags->markdown_file) << table;
  if (!flags->json_file.empty())
    std::ofstream(flags->json_file) << json(run.results(), run.facts());
  std::uint64_t wrong = 0, rays = 0;
  for (const FamilyResult& result : run.results()) {
    wrong += result.tally.sightline.wrong();
    rays += result.tally.sightline.rays;
  }
  std::cout << "judged " << rays << " rays, sightline wrong " << wrong << std::endl;
  return wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace sightline::stress

int main(int argc, char** argv) { return sightline::stress::main_with({argv + 1, argv + argc}); }
