#include "core/run/nearest_miss.h"

#include <algorithm>
#include <cmath>

#include "core/base/within_memory.h"
#include "core/query/sweep_batch.h"

namespace sightline {

Status nearest_miss(const Engine& engine, const Scene& scene, const Ray& ray,
                    const RayOptions& options, const Deadline& deadline,
                    std::optional<NearestMiss>& miss) {
  return within_memory("there is no memory for the answer", [&]() -> Status {
    const SceneTrees::Use use(scene.trees());
    const SceneView view(scene);
    miss = nearest_miss(view, ray, options.resolved, deadline);
    if (!view.tree().complete()) {
      // A sweep of a sphere of that radius builds the trees that it comes near.
      SweepBatch sweep;
      const double reach = miss ? miss->distance.high : 0x1p1000;
      sweep.push_back_sphere(ray, std::min(reach, 0x1p1000));
      HitBatch hits;
      if (Status status = engine.sweep(scene, sweep, true, deadline, hits, options); !status) {
        return status;
      }
      miss = nearest_miss(SceneView(scene), ray, options.resolved, deadline);
    }
    return deadline.passed() ? Status(out_of_time(deadline)) : success();
  });
}

}  // namespace sightline
