#include "tests/bench/answer_check.h"

#include <bit>
#include <cstdint>

namespace sightline::bench {

namespace {

std::string place(const RaySet& rays, std::size_t i) {
  return rays.name + " ray " + std::to_string(i);
}

void judge_ray(const RaySet& rays, std::size_t i, const Answers& ours, const Answers* peer,
               const SceneJudge& judge, AnswerCheck& check) {
  const Ray ray = rays.rays[i];
  const auto verdict = judge.closest(ray);
  ++check.judged;
  const TriangleId id = verdict ? verdict->id : TriangleId{};
  const bool right =
      ours.hits.id(i) == id && (!verdict || std::bit_cast<std::uint64_t>(ours.hits.t[i]) ==
                                                std::bit_cast<std::uint64_t>(verdict->t_rounded));
  if (!right) {
    ++check.sightline_wrong;
    if (check.example.empty()) check.example = place(rays, i) + ": wrong by the oracle";
  }
  if (peer == nullptr) return;
  const TriangleId theirs = peer->hits.id(i);
  if (theirs == id) return;
  if (peer->hits.hit(i) && verdict && judge.is_tie(ray, theirs, verdict->t)) {
    ++check.ties;
  } else {
    ++check.embree_wrong;
  }
}

}  // namespace

void check_closest(const RaySet& rays, const Answers& ours, const Answers* peer,
                   const SceneJudge* judge, std::size_t sample, AnswerCheck& check) {
  check.rays += rays.size();
  std::vector<std::size_t> differing;
  for (std::size_t i = 0; peer != nullptr && i < rays.size(); ++i) {
    if (ours.hits.id(i) != peer->hits.id(i)) differing.push_back(i);
  }
  check.mismatches += differing.size();
  if (judge == nullptr || sample == 0) return;
  if (judge->slow()) sample = (sample + 7) / 8;
  // Up to a sample of the mismatches, evenly spread, and as many of all rays.
  const auto judge_evenly = [&](std::size_t count, auto ray_of) {
    const std::size_t step = count / sample + 1;
    for (std::size_t k = step / 2; k < count; k += step) {
      judge_ray(rays, ray_of(k), ours, peer, *judge, check);
    }
  };
  judge_evenly(differing.size(), [&](std::size_t k) { return differing[k]; });
  judge_evenly(rays.size(), [](std::size_t k) { return k; });
}

void check_same(const std::string& name, const Answers& reference, const Answers& other,
                AnswerCheck& check) {
  for (std::size_t i = 0; i < reference.hits.size(); ++i) {
    if (reference.hits.id(i) == other.hits.id(i) &&
        std::bit_cast<std::uint64_t>(reference.hits.t[i]) ==
            std::bit_cast<std::uint64_t>(other.hits.t[i])) {
      continue;
    }
    ++check.inconsistent;
    if (check.example.empty()) check.example = name + " differs at ray " + std::to_string(i);
  }
}

void check_any(const std::string& name, const Answers& ours, const Answers& any,
               const Answers* peer, AnswerCheck& check) {
  for (std::size_t i = 0; i < any.occluded.size(); ++i) {
    if ((any.occluded[i] != 0) != ours.hits.hit(i)) {
      ++check.inconsistent;
      if (check.example.empty()) {
        check.example = name + ": any differs from closest at ray " + std::to_string(i);
      }
    }
    if (peer != nullptr && any.occluded[i] != peer->occluded[i]) ++check.any_mismatches;
  }
}

}  // namespace sightline::bench
