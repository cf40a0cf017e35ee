#include "core/query/sweep_batch.h"

#include <cmath>

#include "core/query/box_batch.h"

namespace sightline {

namespace {

SweepFault fault_of_size(const SweepBatch& sweeps, std::size_t i) {
  const SweepShape shape = sweeps.shape[i];
  const bool is_round = shape == SweepShape::kSphere || shape == SweepShape::kCapsule;
  for (int k = 0; k < (is_round ? 1 : 3); ++k) {
    const double size = sweeps.size[i][k];
    if (std::isfinite(size) && size >= 0) continue;
    return {i, is_round ? "radius" : "half", is_round ? SweepFault::kWhole : k,
            std::isfinite(size) ? "SWEEP_SIZE_NEGATIVE" : "SWEEP_SIZE_NOT_FINITE",
            std::isfinite(size) ? "a radius or half extent must not be negative"
                                : "a radius or half extent must be a finite number"};
  }
  return {};
}

/// What a capsule and an oriented box have beside their size is checked as that of a BoxBatch.
SweepFault fault_of_rest(const SweepBatch& sweeps, std::size_t i) {
  const SweepShape shape = sweeps.shape[i];
  if (shape == SweepShape::kSphere || shape == SweepShape::kBox) return {};
  BoxBatch same;
  if (shape == SweepShape::kCapsule) {
    same.push_back(Capsule{{}, sweeps.ends[sweeps.number[i]], 0});
  } else {
    same.push_back(OrientedBox{{}, {}, sweeps.axes[sweeps.number[i]]});
  }
  BoxFault fault;
  if (check_boxes(same, fault)) return {};
  return {i, fault.part, fault.component, fault.code, fault.message};
}

}  // namespace

bool check_sweeps(const SweepBatch& sweeps, SweepFault& fault) {
  RayFault of_ray;
  if (!check_rays(sweeps.rays, of_ray)) {
    fault = {of_ray.ray, of_ray.part, SweepFault::kWhole, of_ray.code, of_ray.message};
    return false;
  }
  for (std::size_t i = 0; i < sweeps.count(); ++i) {
    for (const auto fault_of : {fault_of_size, fault_of_rest}) {
      const SweepFault found = fault_of(sweeps, i);
      if (*found.code == '\0') continue;
      fault = found;
      return false;
    }
  }
  return true;
}

}  // namespace sightline
