#include "core/trace/search/triangle_group.h"

#include <algorithm>

#include "core/geometry/exact_hit.h"

namespace sightline {

namespace {

constexpr std::uint32_t kLeafMembers = 4;
/// Triangles between two readings of the clock.
constexpr std::uint32_t kTrianglesPerLook = 4096;

double middle_of(const Triangle& t, int axis) {
  // Halves first: nothing overflows.
  return std::min({t.v0[axis], t.v1[axis], t.v2[axis]}) * 0.5 +
         std::max({t.v0[axis], t.v1[axis], t.v2[axis]}) * 0.5;
}

}  // namespace

TriangleGroup::TriangleGroup(const Scene& scene, const ResolvedFilter& resolved,
                             const Deadline& deadline) {
  const SceneDescription& description = scene.description();
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    if (description.instances[i].hidden) continue;
    const Mesh& mesh = *description.meshes[description.instances[i].mesh];
    for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
      if (resolved.sides[resolved.first[i] + p] == 0) continue;
      const Primitive& primitive = mesh.primitives[p];
      for (std::uint32_t k = 0; k < primitive.triangle_count; ++k) {
        if (k % kTrianglesPerLook == 0 && deadline.passed()) return;
        const TriangleId id{i, primitive.first_triangle + k};
        const Triangle triangle = scene.world_triangle(id);
        if (is_finite(triangle) && !is_degenerate(triangle)) members_.push_back({id, triangle});
      }
    }
  }
  if (members_.empty() || deadline.passed()) return;
  nodes_.push_back({{}, {}, 0, static_cast<std::uint32_t>(members_.size()), 0});
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (i % kTrianglesPerLook == 0 && deadline.passed()) return;
    split(i);
  }
}

/// Bounds a node, and halves it at the middle member of its longest axis.
void TriangleGroup::split(std::uint32_t number) {
  Node& node = nodes_[number];
  const auto begin = members_.begin() + node.first, end = begin + node.count;
  for (auto member = begin; member != end; ++member) {
    node.box.include(member->triangle.v0);
    node.box.include(member->triangle.v1);
    node.box.include(member->triangle.v2);
    node.least = std::min(node.least, member->id);
  }
  if (node.count <= kLeafMembers) return;
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (node.box.max[k] - node.box.min[k] > node.box.max[axis] - node.box.min[axis]) axis = k;
  }
  const std::uint32_t half = node.count / 2;
  std::nth_element(begin, begin + half, end, [axis](const Member& a, const Member& b) {
    const double x = middle_of(a.triangle, axis), y = middle_of(b.triangle, axis);
    return x != y ? x < y : a.id < b.id;
  });
  const std::uint32_t first = node.first, count = node.count;
  node.child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, {}, first, half, 0});
  nodes_.push_back({{}, {}, first + half, count - half, 0});
}

}  // namespace sightline
