#pragma once
/// First the same answers, then the clock.

#include <cstddef>
#include <string>

#include "tests/bench/contestant.h"
#include "tests/bench/scene_judge.h"

namespace sightline::bench {

/// What was compared and judged for one set of rays. "Wrong" counts rays.
struct AnswerCheck {
  std::size_t rays = 0;
  std::size_t mismatches = 0;       ///< Sightline and Embree name different triangles, or one none
  std::size_t judged = 0;           ///< by the oracle: some mismatches and some of all rays
  std::size_t sightline_wrong = 0;  ///< judged: hit, id or a bit of t
  std::size_t embree_wrong = 0;     ///< judged: hit or miss, or a triangle that is not the nearest
  std::size_t ties = 0;             ///< judged: Embree named another triangle at the same exact t
  std::size_t inconsistent = 0;     ///< Sightline contestants that differ in a byte, or any-hit
                                    ///< that is not what closest says
  std::size_t any_mismatches = 0;   ///< of Sightline's and Embree's any-hit
  std::string example;              ///< the first wrong or inconsistent ray, for a bug report
};

/// Compares the answers of one exact contestant with Embree's.
/// `peer` may be null: then only a sample of all rays is judged. `judge` may be null: nothing is.
void check_closest(const RaySet& rays, const Answers& ours, const Answers* peer,
                   const SceneJudge* judge, std::size_t sample, AnswerCheck& check);

/// Two exact contestants must agree in every byte.
void check_same(const std::string& name, const Answers& reference, const Answers& other,
                AnswerCheck& check);

/// Any-hit against closest of the same rays (`ours`), and against Embree's any-hit if not null.
void check_any(const std::string& name, const Answers& ours, const Answers& any,
               const Answers* peer, AnswerCheck& check);

}  // namespace sightline::bench
