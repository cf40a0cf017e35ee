/// Batches of sweeps on the threads of the engine.

#include "core/trace/search/sweep.h"

#include <atomic>

#include "core/run/engine_state.h"
#include "core/run/unbuilt_rounds.h"

namespace sightline {

namespace {

/// Sweeps that one thread takes at a time; each reads the clock itself.
constexpr std::size_t kSweepSlice = 16;

}  // namespace

Status Engine::sweep(const Scene& scene, const SweepBatch& sweeps, bool any,
                     const Deadline& deadline, HitBatch& hits, const RayOptions& options) const {
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    hits.resize(sweeps.count());
    const auto view = state_->with_trees(
        scene, sweeps.count(), deadline,
        [&](UnbuiltTrees& unbuilt, std::size_t i, std::vector<std::uint32_t>& trees) {
          unbuilt.swept(sweeps, i, trees);
        });
    if (!view) return view.error();
    std::atomic<bool> stopped{false};
    const auto slice = [&](std::size_t begin, std::size_t end) {
      Sweeps search(*view, options.resolved, deadline);
      const WorkLog::Entry entry(log, search.counts());
      for (std::size_t i = begin; i < end; ++i) {
        search.find(sweeps, i, any, hits);
        if (search.stopped()) return stopped.store(true);
      }
    };
    Status status = state_->run(sweeps.count(), deadline, slice, kSweepSlice);
    if (status && stopped.load()) return Status(out_of_time(deadline));
    return status;
  });
}

Status Engine::sweep_details(const Scene& scene, const SweepBatch& sweeps, const HitBatch& hits,
                             const Deadline& deadline, Column<HitDetail>& out) const {
  return within_memory([&]() -> Status {
    out.assign(hits.size(), {});
    const auto slice = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (hits.hit(i)) out[i] = detail_of_contact(scene, sweeps, i, hits.id(i));
      }
    };
    return state_->run(hits.size(), deadline, slice, kSweepSlice);
  });
}

}  // namespace sightline
