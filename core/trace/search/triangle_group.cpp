#include "core/trace/search/triangle_group.h"

#include <algorithm>
#include <limits>

#include "core/geometry/exact_hit.h"

namespace sightline {

namespace {

/// Triangles between two readings of the clock.
constexpr std::uint32_t kTrianglesPerLook = 4096;

float middle_of(double a, double b, double c) {
  // Halves first: nothing overflows.
  constexpr double kMost = std::numeric_limits<float>::max();
  const double middle = std::min({a, b, c}) * 0.5 + std::max({a, b, c}) * 0.5;
  return static_cast<float>(std::clamp(middle, -kMost, kMost));
}

Vec3f middle_of(const Triangle& t) {
  return {middle_of(t.v0.x, t.v1.x, t.v2.x), middle_of(t.v0.y, t.v1.y, t.v2.y),
          middle_of(t.v0.z, t.v1.z, t.v2.z)};
}

}  // namespace

TriangleGroup::TriangleGroup(const Scene& scene, const ResolvedFilter& resolved,
                             const Deadline& deadline)
    : scene_(scene) {
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
        if (is_finite(triangle) && !is_degenerate(triangle)) {
          members_.push_back({id, middle_of(triangle)});
        }
      }
    }
  }
  if (members_.empty() || deadline.passed()) return;
  nodes_.push_back({{}, {}, 0, static_cast<std::uint32_t>(members_.size()), 0});
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (i % kTrianglesPerLook == 0 && deadline.passed()) return;
    divide(i);
  }
  // The children of a node follow it.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    if (i % kTrianglesPerLook == 0 && deadline.passed()) return;
    bound(nodes_[i]);
  }
}

/// Halves a node at the middle member of the axis on which its members are spread most.
void TriangleGroup::divide(std::uint32_t number) {
  const Node& node = nodes_[number];
  if (node.count <= kLeafMembers) return;
  const auto begin = members_.begin() + node.first, end = begin + node.count;
  Box3d middles;
  for (auto member = begin; member != end; ++member) {
    const Vec3f& m = member->middle;
    middles.include(Vec3d{m.x, m.y, m.z});
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (middles.max[k] - middles.min[k] > middles.max[axis] - middles.min[axis]) axis = k;
  }
  const std::uint32_t half = node.count / 2;
  std::nth_element(begin, begin + half, end, [axis](const Member& a, const Member& b) {
    const float x = a.middle[axis], y = b.middle[axis];
    return x != y ? x < y : a.id < b.id;
  });
  const std::uint32_t first = node.first, count = node.count;
  nodes_[number].child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, {}, first, half, 0});
  nodes_.push_back({{}, {}, first + half, count - half, 0});
}

/// Sets the box and the smallest id of a node, whose children have theirs.
void TriangleGroup::bound(Node& node) const {
  if (node.child != 0) {
    const Node &a = nodes_[node.child], &b = nodes_[node.child + 1];
    node.box = a.box;
    node.box.include(b.box);
    node.least = std::min(a.least, b.least);
    return;
  }
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const Triangle t = triangle(i);
    for (const Vec3d& corner : {t.v0, t.v1, t.v2}) node.box.include(corner);
    node.least = std::min(node.least, id(i));
  }
}

}  // namespace sightline
