#include "tests/oracle/world_triangles.h"

#include <algorithm>

namespace sightline::oracle {

WorldTriangles::WorldTriangles(const Scene& scene) {
  const SceneDescription& description = scene.description();
  triangles.reserve(scene.instanced_triangle_count());
  for (std::uint32_t i = 0; i < description.instances.size(); ++i) {
    first.push_back(triangles.size());
    const std::uint32_t count = description.meshes[description.instances[i].mesh]->triangle_count();
    for (std::uint32_t k = 0; k < count; ++k) {
      const WorldTriangle world = scene.world_triangle({i, k});
      triangles.push_back({world.v0, world.v1, world.v2});
    }
  }
  first.push_back(triangles.size());
}

TriangleId WorldTriangles::id(std::size_t index) const {
  // Instances without triangles share their first index with the next one: take the last.
  const auto after = std::upper_bound(first.begin(), first.end(), index);
  const auto instance = static_cast<std::size_t>(after - first.begin()) - 1;
  return {static_cast<std::uint32_t>(instance),
          static_cast<std::uint32_t>(index - first[instance])};
}

}  // namespace sightline::oracle
