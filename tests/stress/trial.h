#pragma once
/// One family, one seed: makes the scene and the rays, asks everybody, lets the oracle judge.

#include "core/run/engine.h"
#include "tests/stress/case.h"
#include "tests/stress/tally.h"

namespace sightline::stress {

struct TrialOptions {
  std::size_t rays = 4000;
  std::string kernel;  ///< of Engine::kernels(); empty: the best
  int threads = 1;
  Joining joining = Joining::kMeasured;
  std::size_t list_every = 4;  ///< one ray in so many is judged in the modes all and count
};

/// The seed alone decides scene and rays. An error of the engine or the scene counts as one wrong
/// answer and is told in `failures`.
FamilyTally run_trial(const Family& family, std::uint64_t seed, const TrialOptions& options);

}  // namespace sightline::stress
