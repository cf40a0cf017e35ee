#pragma once
/// Rays that every contestant gets in its own number format: the same numbers, because they are
/// float32.

#include <string>

#include "core/base/column.h"
#include "core/query/ray_batch.h"

namespace sightline::bench {

struct FloatRays {
  Column<float> ox, oy, oz, dx, dy, dz, tmin, tmax;
};

struct RaySet {
  std::string name;
  FloatRays floats;  ///< for contestants that compute in float32
  RayBatch rays;     ///< the same numbers

  std::size_t size() const { return rays.size(); }
  /// Rounds every number to float32. The limits are 0 and ray.tmax.
  void push_back(const Ray& ray);
};

}  // namespace sightline::bench
