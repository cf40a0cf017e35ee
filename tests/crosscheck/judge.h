#pragma once
/// Compares two answers to the same rays and lets the oracle decide.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "tests/crosscheck/embree_scene.h"
#include "tests/oracle/scene_oracle.h"
#include "tests/oracle/world_triangles.h"

namespace sightline::crosscheck {

/// What Sightline answered to the same batch.
struct Answers {
  HitBatch closest;
  Column<std::uint8_t> any;
};

struct Verdict {
  std::size_t rays = 0;
  std::size_t hits = 0;
  std::size_t judged = 0;           ///< asked of the oracle: disagreements and the sample
  std::size_t sightline_wrong = 0;  ///< hit, triangle, bits of t, or any
  std::size_t embree_wrong = 0;     ///< hit, triangle (not a tie), or any
  std::size_t tie = 0;              ///< Embree named another triangle with exactly the same t
  std::vector<std::string> wrong;   ///< the first few wrong answers of Sightline, in full

  void add(const Verdict& other);
  /// Exactly three lines: "sightline wrong N", "embree wrong N", "tie N".
  std::string lines() const;
};

/// Where Sightline and Embree disagree the oracle decides; of the rest it judges one ray in
/// `sample_every`, bits of t included. Runs on two threads.
Verdict judge(const RayBatch& rays, const Answers& answers, const EmbreeScene& embree,
              const oracle::SceneOracle& oracle, const oracle::WorldTriangles& triangles,
              std::size_t sample_every);

}  // namespace sightline::crosscheck
