#pragma once
/// Reads what a scene's file states about surfaces, at hits.

#include <array>
#include <cstdint>
#include <optional>

#include "core/geometry/normal_map.h"
#include "core/query/hit_batch.h"
#include "core/scene/scene.h"

namespace sightline {

/// Reads hits one after the other, as HitAttributes has them; neighbours often lie on one
/// placement. One for each thread; the scene outlives it and counts what it has read when it goes.
class SurfaceReader {
 public:
  explicit SurfaceReader(const Scene& scene) : scene_(scene) {}
  ~SurfaceReader() { scene_.attribute_bytes().fetch_add(touched_, std::memory_order_relaxed); }
  SurfaceReader(const SurfaceReader&) = delete;
  SurfaceReader& operator=(const SurfaceReader&) = delete;

  /// Precondition: id names a triangle of the scene.
  void go_to(TriangleId id, const HitDetail& detail);
  // Of the hit that it has gone to. Throw std::bad_alloc.
  Vec3d shading_normal();
  std::array<double, 2> uv();
  std::array<double, 4> colour();

 private:
  /// False: the file says nothing, or something that is not a number. A fourth number that the file
  /// does not have is 1.
  bool interpolate(VertexAttribute attribute, double (&out)[4]);

  const Scene& scene_;
  std::uint64_t touched_ = 0;
  const PrimitiveAttributes* attributes_ = nullptr;
  std::array<std::uint32_t, 3> corners_{};
  double weight_[3] = {};
  std::uint32_t instance_ = kNone;
  std::optional<NormalMap> normals_;  ///< of the instance, when it was asked for
};

}  // namespace sightline

// Tests: tests/integration/attributes_test.py
