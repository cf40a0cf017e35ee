/// Samples of hemispheres as batches of rays.

#include <algorithm>

#include "core/run/engine_state.h"

namespace sightline {

Status Engine::sky(const Scene& scene, const Hemisphere& samples, const RayRange& range,
                   const Deadline& deadline, Column<std::uint64_t>& unblocked,
                   const RayOptions& options) const {
  return within_memory([&]() -> Status {
    const std::uint64_t count = samples.count;
    unblocked.assign(samples.points.size(), 0);
    const std::size_t at_once = std::max<std::size_t>(1, kRaysAtOnce / count);
    // A batch is a piece of the work: so many are known before the first one.
    Deadline of_batch = deadline;
    of_batch.progress = nullptr;
    if (deadline.progress != nullptr)
      deadline.progress->all += (samples.points.size() + at_once - 1) / at_once;
    Column<std::uint8_t> blocked;
    for (std::size_t begin = 0; begin < samples.points.size(); begin += at_once) {
      const std::size_t end = std::min(samples.points.size(), begin + at_once);
      const auto part = [&](const std::vector<Vec3d>& all) {
        return std::vector<Vec3d>(all.begin() + static_cast<std::ptrdiff_t>(begin),
                                  all.begin() + static_cast<std::ptrdiff_t>(end));
      };
      const auto rays =
          generate_rays({.kind = Hemisphere{part(samples.points), part(samples.normals), count,
                                            samples.seed, samples.uniform, samples.first + begin},
                         .range = range});
      if (!rays) return rays.error();
      if (Status status = any(scene, *rays, of_batch, blocked, options); !status) return status;
      for (std::size_t ray = 0; ray < blocked.size(); ++ray)
        unblocked[begin + ray / count] += blocked[ray] == 0 ? 1u : 0u;
      if (deadline.progress != nullptr) ++deadline.progress->done;
    }
    return success();
  });
}

}  // namespace sightline
