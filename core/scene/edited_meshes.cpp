#include "core/scene/edited_meshes.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/scene/degenerate_triangles.h"

namespace sightline {

namespace {

using Positions = std::span<const Vec3f>;

/// Never 0.
std::uint64_t positions_hash(Positions positions) {
  ContentHash hash;
  hash.add(std::as_bytes(positions));
  return hash.value() | 1u;
}

bool has_positions(const Mesh& mesh, Positions positions) {
  return mesh.positions.size() == positions.size() &&
         std::memcmp(mesh.positions.data(), positions.data(), positions.size_bytes()) == 0;
}

std::shared_ptr<const Mesh> with_positions(const Mesh& mesh, const SharedColumn<Vec3f>& positions,
                                           std::uint64_t hash) {
  auto edited = std::make_shared<Mesh>(mesh);
  edited->positions = positions;
  edited->edited = hash;
  const DegenerateTriangles found = count_degenerate_triangles(*edited);
  edited->nonfinite_triangles = found.nonfinite;
  edited->degenerate_triangles = found.degenerate;
  return edited;
}

/// Places meshes with other positions in a scene.
class EditedMeshes {
 public:
  EditedMeshes(SceneDescription& scene, const HeldMeshes& held, PosedMeshes& posed)
      : scene_(scene), posed_(posed), uses_(held.begin(), held.end()) {
    uses_.resize(scene.meshes.size());
    std::vector<bool> is_posed(scene.meshes.size());
    for (const Instance& instance : scene.instances) {
      if (!scene.nodes[instance.node].removed) ++uses_[instance.mesh];
      if (instance.posed) is_posed[instance.mesh] = true;
    }
    for (std::uint32_t i = 0; i < scene.meshes.size(); ++i) {
      const Mesh& mesh = *scene.meshes[i];
      if (uses_[i] > 0 && !is_posed[i]) known_.emplace(std::pair(mesh.file_mesh, mesh.edited), i);
    }
  }

  /// Precondition: the node has instances, whose mesh has so many positions.
  void set(std::uint32_t node, const SharedColumn<Vec3f>& positions) {
    const auto instances = instances_of(std::span(scene_.instances), node);
    const std::uint32_t before = instances.front().mesh;
    const std::uint64_t hash = positions_hash(positions);
    const std::uint32_t mesh = find(scene_.meshes[before]->file_mesh, hash, positions);
    const std::uint32_t now =
        mesh != kNone ? mesh : place(before, instances.size(), positions, hash);
    if (mesh == before) return;
    uses_[before] -= instances.size();
    uses_[now] += instances.size();
    for (Instance& instance : instances) {
      instance.mesh = now;
      posed_.instances.push_back(static_cast<std::uint32_t>(&instance - scene_.instances.data()));
    }
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// A mesh of these positions: one that has them from the file, or an edited one.
  std::uint32_t find(std::uint32_t file_mesh, std::uint64_t hash, Positions positions) const {
    for (const std::uint64_t edited : {std::uint64_t{0}, hash}) {
      const auto [begin, end] = known_.equal_range({file_mesh, edited});
      for (auto each = begin; each != end; ++each) {
        const Mesh& mesh = *scene_.meshes[each->second];
        // It may have been replaced since.
        if (mesh.file_mesh == file_mesh && mesh.edited == edited && uses_[each->second] > 0 &&
            has_positions(mesh, positions))
          return each->second;
      }
    }
    return kNone;
  }

  /// Makes a mesh in the place of `before` if only the `count` instances have that, else a new one.
  std::uint32_t place(std::uint32_t before, std::size_t count, const SharedColumn<Vec3f>& positions,
                      std::uint64_t hash) {
    auto mesh = with_positions(*scene_.meshes[before], positions, hash);
    std::uint32_t at = before;
    if (uses_[before] > count) {
      at = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.emplace_back();
      uses_.push_back(0);
    }
    known_.emplace(std::pair(mesh->file_mesh, hash), at);
    scene_.meshes[at] = std::move(mesh);
    posed_.fresh.push_back(at);
    return at;
  }

  SceneDescription& scene_;
  PosedMeshes& posed_;
  /// by mesh: instances of nodes that are not removed, and one more if it is held
  std::vector<std::size_t> uses_;
  /// by Mesh::file_mesh and Mesh::edited: meshes that no skin poses
  std::multimap<std::pair<std::uint32_t, std::uint64_t>, std::uint32_t> known_;
};

}  // namespace

Status set_positions(SceneDescription& scene, std::span<const NodeChange> changes,
                     std::size_t sampled, const NodeNumbers& numbers, const HeldMeshes& held,
                     PosedMeshes& posed) {
  std::unique_ptr<EditedMeshes> meshes;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const SharedColumn<Vec3f>& positions = changes[i].positions;
    const std::uint32_t node = positions.empty() ? 0 : numbers.at(changes[i].node);
    if (positions.empty() || scene.nodes[node].removed) continue;
    const std::string pointer = pointer_of_change(i, sampled) + "/positions";
    if (Status status = check_unposed(scene, node, pointer); !status) return status;
    const auto instances = instances_of(std::span(scene.instances), node);
    const std::size_t count = scene.meshes[instances.front().mesh]->positions.size();
    if (positions.size() != count) {
      return Error{ErrorKind::kInvalid, "NODE_POSITIONS_WRONG",
                   "the mesh of node " + std::to_string(changes[i].node) + " has " +
                       std::to_string(count) + " vertices, these are " +
                       std::to_string(positions.size()) + " positions",
                   pointer};
    }
    if (!meshes) meshes = std::make_unique<EditedMeshes>(scene, held, posed);
    meshes->set(node, positions);
  }
  if (!meshes) return success();
  posed.renumbered = remove_unused_meshes(scene, held) || posed.renumbered;
  count_flat_triangles(scene);
  return success();
}

std::vector<bool> used_meshes(const SceneDescription& scene) {
  std::vector<bool> used(scene.meshes.size());
  for (const Instance& instance : scene.instances) used[instance.mesh] = true;
  return used;
}

bool remove_unused_meshes(SceneDescription& scene, const HeldMeshes& held) {
  const std::vector<bool> used = used_meshes(scene);
  bool has_unused = false;
  for (std::size_t i = 0; i < used.size(); ++i)
    has_unused = has_unused || (!used[i] && (i >= held.size() || !held[i]));
  if (!has_unused) return false;
  std::vector<std::uint32_t> number(scene.meshes.size());
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    number[i] = count;
    scene.meshes[count++] = std::move(scene.meshes[i]);
  }
  scene.meshes.resize(count);
  for (Instance& instance : scene.instances) instance.mesh = number[instance.mesh];
  return true;
}

void count_flat_triangles(SceneDescription& scene) {
  const std::vector<bool> used = used_meshes(scene);
  scene.counts.nonfinite_triangles = scene.counts.degenerate_triangles = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    scene.counts.nonfinite_triangles += scene.meshes[i]->nonfinite_triangles;
    scene.counts.degenerate_triangles += scene.meshes[i]->degenerate_triangles;
  }
}

}  // namespace sightline
