/// Batches of points on the threads of the engine.

#include "core/trace/search/nearest.h"

#include <atomic>

#include "core/run/engine_state.h"
#include "core/run/unbuilt_rounds.h"

namespace sightline {

namespace {

/// Points that one thread takes at a time. One may be as far from a whole scene, so it reads the
/// clock itself.
constexpr std::size_t kPointSlice = 64;

}  // namespace

Status Engine::nearest(const Scene& scene, const Column<Vec3d>& points, double max_distance,
                       std::size_t count, const Deadline& deadline, HitBatch& hits,
                       const RayOptions& options) const {
  const SceneTrees::Use use(scene.trees());
  WorkLog log(scene, options.work);
  return within_memory([&]() -> Status {
    hits.resize(points.size() * count);
    Column<double> reach(points.size());
    /// Of the points that number(i) names, for all i below `some`.
    const auto look = [&](const SceneView& view, std::size_t some, auto number) {
      std::atomic<bool> stopped{false};
      const auto slice = [&](std::size_t begin, std::size_t end) {
        NearestTriangles nearest(view, options.resolved, deadline);
        const WorkLog::Entry entry(log, nearest.counts());
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t at = number(i);
          nearest.find(points[at], max_distance, count);
          if (nearest.stopped()) return stopped.store(true);
          reach[at] = nearest.reach();
          nearest.write(at * count, hits);
        }
      };
      Status status = state_->run(some, deadline, slice, kPointSlice);
      if (status && stopped.load()) return Status(out_of_time(deadline));
      return status;
    };
    const SceneView view(scene);
    Status status = look(view, points.size(), [](std::size_t i) { return i; });
    if (!status || view.tree().complete()) return status;
    return state_->trace_again(
        view, points.size(), deadline,
        [&](UnbuiltTrees& unbuilt, std::span<const std::size_t> numbers, std::uint32_t* next) {
          for (const std::size_t i : numbers) *next++ = unbuilt.nearest_to(points[i], reach[i]);
        },
        [&](const SceneView& later, std::span<const std::size_t> numbers) {
          return look(later, numbers.size(), [&](std::size_t i) { return numbers[i]; });
        });
  });
}

Status Engine::nearest_details(const Scene& scene, const Column<Vec3d>& points,
                               const HitBatch& hits, const Deadline& deadline,
                               Column<HitDetail>& out) const {
  return within_memory([&]() -> Status {
    out.assign(hits.size(), {});
    const auto slice = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!hits.hit(i)) continue;
        out[i] = detail_of_nearest(scene, points[i], hits.id(i));
      }
    };
    return state_->run(hits.size(), deadline, slice, kPointSlice);
  });
}

}  // namespace sightline
