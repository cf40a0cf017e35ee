#pragma once
/// Vertex positions as the file encodes them: decoded, morphed, rounded once.

#include <cstdint>
#include <vector>

#include "core/geometry/vec3.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/skinning.h"

namespace sightline::gltf {

/// A morph target with a weight that is not zero.
struct WeightedTarget {
  AccessorView deltas;
  double weight = 0;
};

/// Writes positions first .. first + count - 1. Per component, in float64 without FMA:
///   p = base;  p = p + w_k * d_k  for each target k in file order;  p is posed by the skin when
///   there is one (skinning.h);  round p once to float32
/// base and d_k are float32 widened, or integers decoded by glTF's formula (accessor.h). A float32
/// position without targets and skin is copied as it stands. Targets whose weight is zero are left
/// out. What it gives and its errors are those of pose().
Result<std::uint64_t> load_positions(const AccessorView& base,
                                     const std::vector<WeightedTarget>& targets,
                                     const Skinning& skinning, std::uint64_t first,
                                     std::uint64_t count, const std::string& place, Vec3f* out);

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
