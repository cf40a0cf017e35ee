#pragma once
/// Closest hits with somebody else's triangle test on the product's own tree, traversed as the
/// product does it: conservative boxes, the same order, as many rays in flight. What differs in
/// time and in answers is the triangle test and what it needs.

#include <cstddef>
#include <span>
#include <string_view>

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "core/scene/scene.h"

namespace sightline::contestants {

struct TextbookKernel {
  std::string_view name;
  bool float32 = true;  ///< whether it computes in float32, rays included
  /// Rays [begin, end) of a checked batch; slots of the same numbers are overwritten. Of triangles
  /// at the same computed t the smaller id wins. Preconditions: can_trace(scene), tmin >= 0.
  void (*closest)(const Scene& scene, const RayBatch& rays, std::size_t begin, std::size_t end,
                  HitBatch& hits);
};

/// moeller_trumbore_float32, moeller_trumbore_float64, woop_float32, pluecker_float32; compiled for
/// the best instruction set of this machine.
std::span<const TextbookKernel> textbook_kernels();

/// One mesh, placed once, its float32 positions being the world: what textbooks talk about.
bool can_trace(const Scene& scene);

}  // namespace sightline::contestants
