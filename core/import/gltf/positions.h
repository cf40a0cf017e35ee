#pragma once
/// Reads vertex positions: decodes them, applies morph targets and skin, and rounds once.

#include <cstdint>
#include <vector>

#include "core/geometry/vec3.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/skinning.h"

namespace sightline::gltf {

/// A morph target whose weight is not zero.
struct WeightedTarget {
  AccessorView deltas;  ///< one displacement for each vertex
  double weight = 0;
};

/// Writes positions first .. first + count - 1 to `out`. For each component, in float64 without
/// FMA:
///   p = base;  p = p + w_k * d_k  for each target k in the order of the file;
///   if there is a skin, p is posed (skinning.h);  p is rounded once to float32
/// base and d_k are float32 widened, or integers decoded by glTF's formula (accessor.h). A float32
/// position without targets and skin is copied unchanged. Returns the result of pose(): the number
/// of vertices with unbalanced weights, or an error. Preconditions: the positions are in the view,
/// and `out` has room for `count`.
Result<std::uint64_t> load_positions(const AccessorView& base,
                                     const std::vector<WeightedTarget>& targets,
                                     const Skinning& skinning, std::uint64_t first,
                                     std::uint64_t count, const std::string& place, Vec3f* out);

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
