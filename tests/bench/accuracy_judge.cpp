#include "tests/bench/accuracy_judge.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tests/stress/ray_box_cases.h"
#include "tests/stress/ray_box_truth.h"

namespace sightline::bench {

namespace {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void judge_ray(const SceneJudge& judge, const Ray& ray,
               const std::optional<SceneJudge::Verdict>& truth, std::size_t i,
               const Contestant& contestant, const Answers& answers, AccuracyEntry& entry) {
  const bool hit = answers.hits.hit(i);
  if (hit != truth.has_value()) {
    ++(hit ? entry.false_hits : entry.false_misses);
    return;
  }
  if (!hit) return;
  const TriangleId id = answers.hits.id(i);
  const double t = contestant.float64() ? answers.hits.t[i] : static_cast<double>(answers.t[i]);
  const bool right = contestant.exact() ? id == truth->id && same_bits(t, truth->t_rounded)
                                        : id == truth->id || judge.is_tie(ray, id, truth->t);
  if (right) {
    entry.t_errors.push_back(ulp_error(t, truth->t_rounded));
  } else {
    ++entry.wrong_place;
  }
}

double rounded(const mpq_class& t) {
  return oracle::round_to_double(oracle::Rational{t.get_num(), t.get_den(), 0});
}

/// What a text may mean by t.
std::vector<double> meanings(const stress::RayBoxTruth& truth, const Ray& ray) {
  std::vector<double> ts;
  for (const auto* t : {&truth.line.enter, &truth.line.leave, &truth.t}) {
    if (*t) ts.push_back(rounded(**t));
  }
  if (std::isfinite(ray.tmin)) ts.push_back(ray.tmin);
  return ts;
}

}  // namespace

void judge_rays(const SceneJudge& judge, const RaySet& rays, const Contestants& contestants,
                const std::vector<Answers>& answers, AccuracyCell& cell) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray ray = rays.rays[i];
    const auto truth = judge.closest(ray);
    for (std::size_t c = 0; c < contestants.size(); ++c) {
      judge_ray(judge, ray, truth, i, *contestants[c], answers[c],
                cell.entries[contestants[c]->name()]);
    }
  }
}

void judge_pairs(const AccuracyPairs& pairs, const BoxContestants& contestants,
                 std::vector<BoxAnswers>& answers, AccuracyCell& cell) {
  for (BoxAnswers& answer : answers) {
    for (std::size_t i = 0; i < answer.batch.size(); ++i) {
      answer.hit[i] = answer.batch.outcome[i] == RayBoxOutcome::kHit ? 1 : 0;
      answer.t[i] = answer.batch.t[i];
    }
  }
  std::vector<stress::RayBoxCase> tests;
  for (std::size_t i = 0; i < pairs.rays.size(); ++i) {
    const stress::RayBoxCase& test =
        tests.emplace_back(stress::RayBoxCase{pairs.rays[i], pairs.boxes[i], {}});
    const stress::RayBoxTruth truth =
        stress::ray_box_truth(test.ray, oracle::axis_aligned(test.aligned));
    const bool whole_answer_right = stress::judge(test).fault.empty();
    const std::vector<double> ts = meanings(truth, test.ray);
    for (std::size_t c = 0; c < contestants.size(); ++c) {
      AccuracyEntry& entry = cell.entries[contestants[c].name];
      const bool hit = answers[c].hit[i] != 0;
      const bool ours = is_ours(contestants[c].name);
      if (hit != truth.hit) {
        ++(hit ? entry.false_hits : entry.false_misses);
      } else if (ours && !whole_answer_right) {
        ++entry.wrong_place;
      } else if (hit && truth.t) {
        double least = ulp_error(answers[c].t[i], rounded(*truth.t));
        for (const double t : ts) {
          if (!ours) least = std::min(least, ulp_error(answers[c].t[i], t));
        }
        entry.t_errors.push_back(least);
      }
    }
  }
  cell.entries[kOursAll].wrong_place += stress::differing_kernels(tests).size();
}

}  // namespace sightline::bench
