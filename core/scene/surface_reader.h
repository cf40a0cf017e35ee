#pragma once
/// SurfaceReader: reads and interpolates vertex attributes at hits.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/geometry/normal_map.h"
#include "core/query/hit_batch.h"
#include "core/scene/scene.h"

namespace sightline {

/// Reads the attributes of one hit after the other, as HitAttributes defines them. Fast if
/// consecutive hits are on one instance. Each thread has its own reader. The scene must outlive it;
/// the destructor adds the bytes that were read to the scene's counter.
class SurfaceReader {
 public:
  explicit SurfaceReader(const Scene& scene) : scene_(scene) {}
  ~SurfaceReader() { scene_.attribute_bytes().fetch_add(touched_, std::memory_order_relaxed); }
  SurfaceReader(const SurfaceReader&) = delete;
  SurfaceReader& operator=(const SurfaceReader&) = delete;

  /// Selects a hit. Precondition: `id` names a triangle of the scene, and `detail` belongs to the
  /// hit.
  void go_to(TriangleId id, const HitDetail& detail);
  // The attributes of the selected hit; NaN where the file has none. Throw std::bad_alloc.
  // Precondition: go_to was called.
  Vec3d shading_normal();
  std::array<double, 2> uv();
  std::array<double, 2> uv1();
  std::array<double, 4> tangent();
  std::array<double, 4> colour();
  /// Writes the numbers of an attribute that the file names: out.size() of them, which is its
  /// NamedAttribute::components.
  void named(VertexAttribute attribute, std::span<double> out);

 private:
  std::array<double, 2> pair(VertexAttribute attribute);
  const NormalMap& normals();
  /// Interpolates an attribute. False if the file has none, or a value that is not finite. A fourth
  /// number that the file does not have is 1.
  bool interpolate(VertexAttribute attribute, double (&out)[4]);

  const Scene& scene_;
  std::uint64_t touched_ = 0;
  const PrimitiveAttributes* attributes_ = nullptr;
  std::array<std::uint32_t, 3> corners_{};
  double weight_[3] = {};
  std::uint32_t instance_ = kNone;
  std::optional<NormalMap> normals_;  ///< of the instance, once a normal was requested
};

}  // namespace sightline

// Tests: tests/integration/attributes_test.py
