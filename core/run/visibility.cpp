/// Pairs of points as batches of rays.

#include <algorithm>
#include <new>

#include "core/run/engine.h"

namespace sightline {

Status Engine::visibility(const Scene& scene, const PointPairs& pairs, const Deadline& deadline,
                          Column<std::uint8_t>& visible, HitBatch* blockers,
                          const RayOptions& options) const try {
  visible.resize(pairs.size());
  if (blockers != nullptr) blockers->resize(0);
  RayBatch rays;
  HitBatch hits;
  Column<std::uint8_t> blocked;
  for (std::size_t begin = 0; begin < pairs.size(); begin += kRaysAtOnce) {
    const std::size_t count = std::min(kRaysAtOnce, pairs.size() - begin);
    rays.resize(0);
    for (std::size_t i = 0; i < count; ++i) rays.push_back(pairs.ray(begin + i));
    Status status = blockers != nullptr ? closest(scene, rays, deadline, hits, options)
                                        : any(scene, rays, deadline, blocked, options);
    if (!status) return status;
    for (std::size_t i = 0; i < count; ++i) {
      const bool met = blockers != nullptr ? hits.hit(i) : blocked[i] != 0;
      visible[begin + i] = met ? 0 : 1;
    }
    if (blockers != nullptr) blockers->append(hits);
  }
  return success();
} catch (const std::bad_alloc&) {
  return Error{ErrorKind::kOutOfSpace, "MEMORY_EXHAUSTED", "there is no memory for the answer", ""};
}

}  // namespace sightline
