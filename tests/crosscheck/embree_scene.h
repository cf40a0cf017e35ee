#pragma once
/// Embree over the scene's triangles, rounded to float32: a contestant, never a judge. Debian 12 has
/// Embree 3.13, Debian 13 has 4.3.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cstdint>
#include <optional>
#include <span>

#include "core/query/ray_batch.h"
#include "tests/oracle/exact_triangle.h"

namespace sightline::crosscheck {

struct EmbreeHit {
  std::size_t triangle = 0;
  float t = 0;
};

/// One Embree scene; may be asked from many threads at once.
class EmbreeScene {
 public:
  /// Every corner is rounded to float32. Non-finite ones stay as they are: Embree leaves their
  /// triangles out.
  EmbreeScene(std::span<const oracle::Triangle> triangles, bool robust);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Debian builds Embree with its assertions on: a ray beyond 1.8e18, not finite in float32
  /// or with a negative tmin aborts the process. Such a ray must not be asked.
  static bool accepts(const Ray& ray);

  // Precondition: accepts(ray). The ray is rounded to float32.
  std::optional<EmbreeHit> closest(const Ray& ray) const;
  bool any(const Ray& ray) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace sightline::crosscheck
