#pragma once
/// Holds what contestants of the accuracy benchmark answered against the oracle, every ray of it.

#include <functional>

#include "core/query/ray_box_answers.h"
#include "tests/bench/accuracy_rays.h"
#include "tests/bench/accuracy_result.h"
#include "tests/bench/contestant.h"
#include "tests/bench/scene_judge.h"

namespace sightline::bench {

using Contestants = std::vector<std::unique_ptr<Contestant>>;

/// A triangle counts as right if it is met at the exact least t; of an exact contestant the id must
/// be the promised one of a tie, and every bit of t right. Fills cell.entries.
void judge_rays(const SceneJudge& judge, const RaySet& rays, const Contestants& contestants,
                const std::vector<Answers>& answers, AccuracyCell& cell);

struct BoxAnswers {
  std::vector<std::uint8_t> hit;
  std::vector<double> t;
  RayBoxAnswers batch;  ///< of a contestant that answers with it; then hit and t are not set
};
struct BoxContestant {
  std::string name;
  /// Precondition: the answers have as many slots as there are pairs.
  std::function<void(const AccuracyPairs&, BoxAnswers&)> run;
};
using BoxContestants = std::vector<BoxContestant>;

/// A contestant's t is taken for what it is nearest to: the entry, the exit, the lower limit from
/// inside, or the first point on the surface; texts differ in what they call t. Sightline is held
/// to every field of its answer. Fills cell.entries. Sets hit and t of answers that are batches.
void judge_pairs(const AccuracyPairs& pairs, const BoxContestants& contestants,
                 std::vector<BoxAnswers>& answers, AccuracyCell& cell);

}  // namespace sightline::bench
