#include "core/query/sweep_batch.h"

#include <cmath>

namespace sightline {

bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault) {
  RayFault of_ray;
  if (!check_rays(sweeps.rays, of_ray)) {
    fault = {of_ray.ray, of_ray.part, SweepFault::kWhole, of_ray.code, of_ray.message};
    return false;
  }
  for (std::size_t i = 0; i < sweeps.count(); ++i) {
    const bool is_sphere = sweeps.sphere[i] != 0;
    for (int k = 0; k < (is_sphere ? 1 : 3); ++k) {
      const double size = sweeps.size[i][k];
      if (std::isfinite(size) && size >= 0) continue;
      fault = {i, is_sphere ? "radius" : "half", is_sphere ? SweepFault::kWhole : k,
               std::isfinite(size) ? "SWEEP_SIZE_NEGATIVE" : "SWEEP_SIZE_NOT_FINITE",
               std::isfinite(size) ? "a radius or half extent must not be negative"
                                   : "a radius or half extent must be a finite number"};
      return false;
    }
  }
  return true;
}

}  // namespace sightline
