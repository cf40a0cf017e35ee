#include "server/service/scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace sightline {
namespace {

/// A mesh of the plan with those of its placements that are drawn.
struct DrawnMesh {
  std::uint32_t mesh = 0;          ///< in the description
  std::pair<double, double> size;  ///< the largest apparent size and diagonal of a placement
  std::vector<std::uint32_t> instances;
};

double diagonal(const Box3d& box) {
  return std::hypot(box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z);
}

double distance(const Vec3d& point, const Box3d& box) {
  const auto away = [](double x, double low, double high) {
    return std::max({low - x, 0.0, x - high});
  };
  return std::hypot(away(point.x, box.min.x, box.max.x), away(point.y, box.min.y, box.max.y),
                    away(point.z, box.min.z, box.max.z));
}

/// How large a box appears from the eye, and its diagonal. Never NaN.
std::pair<double, double> size_of(const Box3d& box, const std::optional<Vec3d>& eye) {
  const double size = diagonal(box);
  if (!eye) return {size, size};
  const double away = distance(*eye, box);
  if (away == 0) return {std::numeric_limits<double>::infinity(), size};
  // Both may be infinite.
  const double apparent = size / away;
  return {apparent >= 0 ? apparent : 0, size};
}

/// Same triangles in the same parts: then one mesh can stand for the other.
bool has_same_parts(const Mesh& a, const Mesh& b) {
  return std::equal(a.primitives.begin(), a.primitives.end(), b.primitives.begin(),
                    b.primitives.end(), [](const Primitive& p, const Primitive& q) {
                      return p.triangle_count == q.triangle_count && p.material == q.material;
                    });
}

/// In the order of GeometryRange.
std::vector<DrawnMesh> drawn_meshes(const Scene& scene, const std::optional<Vec3d>& eye) {
  const ScenePlan& plan = scene.trees().plan();
  const SceneDescription& description = scene.description();
  std::vector<DrawnMesh> all(plan.meshes.size());
  for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
    if (plan.placed[i].empty() || description.instances[i].hidden) continue;
    const std::uint32_t own = description.instances[i].mesh, first = plan.placements[i].mesh;
    const bool is_same = has_same_parts(*description.meshes[own], *description.meshes[first]);
    DrawnMesh& drawn = all[is_same ? first : own];
    drawn.mesh = is_same ? first : own;
    drawn.size = std::max(drawn.size, size_of(plan.exact_bounds(i, 1), eye));
    drawn.instances.push_back(i);
  }
  std::erase_if(all, [](const DrawnMesh& mesh) { return mesh.instances.empty(); });
  // Not by the numbers of meshes, which depend on the way to the present content.
  std::sort(all.begin(), all.end(), [](const DrawnMesh& a, const DrawnMesh& b) {
    return a.size != b.size ? a.size > b.size : a.instances.front() < b.instances.front();
  });
  return all;
}

std::uint64_t bytes_of(const Mesh& mesh, std::size_t placements) {
  return kMeshBytes + mesh.positions.size() * kPositionBytes +
         mesh.triangle_count() * kTriangleBytes + mesh.primitives.size() * kPartBytes +
         placements * kPlacementBytes;
}

Vec3d middle_of(const Box3d& box) {
  // Halves first: the sum of two large numbers may be infinite.
  return {box.min.x / 2 + box.max.x / 2, box.min.y / 2 + box.max.y / 2,
          box.min.z / 2 + box.max.z / 2};
}

void add_mesh(GeometryAnswer& answer, const Scene& scene, const DrawnMesh& drawn) {
  const SceneDescription& description = scene.description();
  // Of meshes with equal content, that of the first instance: which of them the plan names depends on
  // the way to the present content.
  const Mesh& mesh = *description.meshes[description.instances[drawn.instances.front()].mesh];
  const auto row = static_cast<std::uint32_t>(answer.meshes.size());
  const Vec3d origin = middle_of(scene.trees().plan().facts[drawn.mesh].box);
  answer.meshes.push_back({mesh.file_mesh, origin, mesh.positions, mesh.indices});
  for (const Primitive& part : mesh.primitives) {
    GeometryPart added{row, part.first_triangle, part.triangle_count, part.file_primitive,
                       part.material};
    if (part.material < description.materials.size())
      added.colour = description.materials[part.material].base_colour;
    answer.parts.push_back(added);
  }
  for (const std::uint32_t i : drawn.instances) {
    const Instance& instance = description.instances[i];
    GeometryPlacement added{row, i, description.nodes[instance.node].file_node};
    const auto& m = instance.world_from_mesh.m;
    for (std::size_t k = 0; k < added.linear.size(); ++k) added.linear[k] = m[k / 3][k % 3];
    for (int r = 0; r < 3; ++r)
      added.at[r] = m[r][0] * origin.x + m[r][1] * origin.y + m[r][2] * origin.z + m[r][3];
    answer.placements.push_back(added);
  }
}

}  // namespace

GeometryAnswer scene_geometry(const Scene& scene, const GeometryRange& range) {
  const auto& meshes = scene.description().meshes;
  const std::vector<DrawnMesh> drawn = drawn_meshes(scene, range.eye);
  GeometryAnswer answer;
  answer.all_meshes = drawn.size();
  std::uint64_t bytes = 0;
  bool is_full = range.max_bytes == 0;
  for (std::uint64_t i = 0; i < drawn.size(); ++i) {
    const std::uint64_t more = bytes_of(*meshes[drawn[i].mesh], drawn[i].instances.size());
    answer.all_bytes += more;
    if (i < range.first || answer.next) continue;
    is_full = is_full || (bytes > 0 && bytes + more > range.max_bytes);
    if (is_full) {
      answer.next = i;
    } else {
      add_mesh(answer, scene, drawn[i]);
      bytes += more;
    }
  }
  return answer;
}

std::uint64_t bytes_of_geometry_lists(const Scene& scene) {
  const SceneDescription& description = scene.description();
  const std::uint64_t parts = std::accumulate(
      description.meshes.begin(), description.meshes.end(), std::uint64_t{0},
      [](std::uint64_t sum, const auto& mesh) { return sum + mesh->primitives.size(); });
  // A vector that grows may have twice its length, beside the old one.
  return 3 * (description.meshes.size() * (sizeof(DrawnMesh) + sizeof(GeometryMesh)) +
              description.instances.size() * (sizeof(std::uint32_t) + sizeof(GeometryPlacement)) +
              parts * sizeof(GeometryPart));
}

std::uint64_t bytes_of_geometry(const GeometryAnswer& answer) {
  constexpr std::uint64_t kTable = 1024;
  std::uint64_t bytes = kTable + answer.meshes.size() * (kMeshBytes + 2 * sizeof(std::uint64_t)) +
                        answer.parts.size() * kPartBytes +
                        answer.placements.size() * kPlacementBytes;
  for (const GeometryMesh& mesh : answer.meshes) {
    bytes += mesh.positions.size() * kPositionBytes + mesh.indices.size() / 3 * kTriangleBytes;
  }
  return bytes;
}

}  // namespace sightline
