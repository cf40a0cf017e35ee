#include "core/import/gltf/mesh_reader.h"

#include <algorithm>
#include <limits>
#include <set>

#include "core/import/gltf/degenerate_triangles.h"
#include "core/import/gltf/positions.h"
#include "core/import/input/mapped_file.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::uint64_t kMostTriangles = 0x55555554u;  ///< of a mesh, so that 3 * it fits in a u32

}  // namespace

Result<std::optional<std::uint32_t>> MeshReader::mesh_of(const tinygltf::Node& node) {
  // A node's weights replace the mesh's; trailing zeros do not tell meshes apart.
  const tinygltf::Mesh& source = document_.model.meshes[static_cast<std::size_t>(node.mesh)];
  std::vector<double> weights = !node.weights.empty() ? node.weights : source.weights;
  while (!weights.empty() && weights.back() == 0) weights.pop_back();
  const auto key = std::make_tuple(node.mesh, weights, node.skin);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;

  Pose pose = {std::move(weights), nullptr};
  if (node.skin >= 0) {
    auto joints = skins_.joints(static_cast<std::size_t>(node.skin));
    if (!joints) return joints.error();
    pose.joints = *joints;
  }
  Mesh mesh;
  mesh.name = source.name;
  mesh.file_mesh = static_cast<std::uint32_t>(node.mesh);
  auto index = source.primitives.size() == 1 ? read_lone(std::move(mesh), pose)
                                             : read_joined(std::move(mesh), pose);
  if (index) known_.emplace(key, *index);
  return index;
}

Result<std::optional<std::uint32_t>> MeshReader::read_lone(Mesh mesh, const Pose& pose) {
  auto found = open_primitive(0, pose, mesh);
  if (!found) return found.error();
  if (!found->has_value()) return std::optional<std::uint32_t>();
  const auto index = static_cast<std::uint32_t>(scene_.meshes.size());
  scene_.meshes.emplace_back();
  const int mode = source_of(mesh, 0).mode;
  Status added = single_primitive_.add(index, std::move(mesh), **std::move(found), mode, pose);
  if (!added) return added.error();
  return std::optional(index);
}

Result<std::optional<std::uint32_t>> MeshReader::read_joined(Mesh mesh, const Pose& pose) {
  LoadedParts loaded;
  for (std::size_t i = 0; i < document_.model.meshes[mesh.file_mesh].primitives.size(); ++i) {
    if (Status status = append_primitive(i, pose, mesh, loaded); !status) return status.error();
  }
  mesh.indices.forget_sequence();
  if (mesh.primitives.empty()) return std::optional<std::uint32_t>();
  const DegenerateTriangles degenerate_triangles = count_degenerate_triangles(mesh);
  mesh.all_used = degenerate_triangles.all_used;
  mesh.nonfinite_triangles = degenerate_triangles.nonfinite;
  mesh.degenerate_triangles = degenerate_triangles.degenerate;
  add_degenerate_triangles(degenerate_triangles, mesh, scene_.counts, warnings_);
  const auto index = static_cast<std::uint32_t>(scene_.meshes.size());
  scene_.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  return std::optional(index);
}

Result<std::optional<PrimitiveSource>> MeshReader::open_primitive(std::size_t number,
                                                                  const Pose& pose, Mesh& mesh) {
  using Found = std::optional<PrimitiveSource>;
  const tinygltf::Primitive& source = source_of(mesh, number);
  const auto attribute = source.attributes.find("POSITION");
  const bool has_triangles = source.mode >= TINYGLTF_MODE_TRIANGLES;
  if (!has_triangles || attribute == source.attributes.end()) {
    ++scene_.counts.skipped_primitives;
    return Found();
  }
  auto found = sources_.find(mesh.file_mesh, number, pose);
  if (!found) return found.error();
  const std::uint64_t listed =
      found->indices.has_value() ? found->indices->count : found->positions.count;
  const std::uint64_t triangles = triangle_count(source.mode, listed);
  if (triangles == 0 || (source.mode == TINYGLTF_MODE_TRIANGLES && listed % 3 != 0)) {
    warnings_.add(found->place + ": " + std::to_string(listed) + " vertices make " +
                  std::to_string(triangles) + " whole triangles");
    if (triangles == 0) return Found();
  }
  if (triangles > budget_.triangles() || triangles + mesh.indices.size() / 3 > kMostTriangles) {
    return beyond_limit("TRIANGLES", found->place + ": triangles so far", budget_.with(triangles),
                        std::min(limits_.triangles, kMostTriangles));
  }
  budget_.spend_triangles(triangles);
  if (Status status = budget_.spend_bytes(triangles * 3 * sizeof(std::uint32_t)); !status)
    return status.error();
  Primitive primitive;
  primitive.first_triangle = static_cast<std::uint32_t>(mesh.indices.size() / 3);
  primitive.triangle_count = static_cast<std::uint32_t>(triangles);
  primitive.file_primitive = static_cast<std::uint32_t>(number);
  if (source.material >= 0) primitive.material = static_cast<std::uint32_t>(source.material);
  mesh.primitives.push_back(primitive);
  return Found(*std::move(found));
}

Status MeshReader::append_primitive(std::size_t number, const Pose& pose, Mesh& mesh,
                                    LoadedParts& loaded) {
  auto opened = open_primitive(number, pose, mesh);
  if (!opened) return opened.error();
  if (!opened->has_value()) return success();
  const PrimitiveSource& found = **opened;
  const tinygltf::Primitive& source = source_of(mesh, number);

  // Corners first: they say which range of vertices is worth reading.
  UnsetColumn<std::uint32_t>& corners = mesh.indices.own();
  const std::size_t first = corners.size();
  if (found.indices.has_value())
    accessors_.announce(*found.indices, 0, found.indices->count, &TouchedBytes::indices);
  corners.resize(first + std::size_t{3} * mesh.primitives.back().triangle_count);
  auto range = load_corners(found.indices, found.positions.count, source.mode, found.place,
                            corners.data() + first);
  if (!range) return range.error();
  auto offset = append_positions(source, found, *range, mesh, loaded);
  if (!offset) return offset.error();
  if (*offset != range->low) {
    for (std::size_t i = first; i < corners.size(); ++i)
      corners[i] = corners[i] - range->low + *offset;
  }
  attributes_.append(found, pose, *range, range->low - *offset, mesh);
  return success();
}

Result<std::uint32_t> MeshReader::append_positions(const tinygltf::Primitive& source,
                                                   const PrimitiveSource& found,
                                                   const CornerRange& range, Mesh& mesh,
                                                   LoadedParts& loaded) {
  // Primitives of one mesh often share their vertices; what stands there already is used again.
  std::vector<int> key = {static_cast<int>(found.positions.accessor)};
  for (const auto& target : source.targets) {
    const auto deltas = target.find("POSITION");
    key.push_back(deltas != target.end() ? deltas->second : -1);
  }
  for (const InfluenceSet& set : found.skinning.sets) {
    key.push_back(static_cast<int>(set.joints.accessor));
    key.push_back(static_cast<int>(set.weights.accessor));
  }
  const auto known = loaded.find(key);
  const bool is_shared = found.decoded == nullptr && known != loaded.end();
  if (is_shared && known->second.low <= range.low && range.high <= known->second.high) {
    return known->second.base + (range.low - known->second.low);
  }
  const std::uint64_t count = range.count();
  const std::uint64_t offset = mesh.positions.size();
  if (offset + count > kMostVertices) {
    return beyond_limit("GEOMETRY_BYTES", "mesh " + std::to_string(mesh.file_mesh) + ": vertices",
                        offset + count, kMostVertices);
  }
  if (Status status = budget_.spend_bytes(count * sizeof(Vec3f)); !status) return status.error();
  will_need(count_vertices(found, range, accessors_));
  UnsetColumn<Vec3f>& positions = mesh.positions.own();
  positions.resize(offset + count);
  auto unbalanced = load_positions(found.positions, found.targets, found.skinning, range.low, count,
                                   found.place, positions.data() + offset);
  if (!unbalanced) return unbalanced.error();
  warn_of_unbalanced(*unbalanced, found.place, warnings_);
  if (found.decoded == nullptr)
    loaded[key] = {range.low, range.high, static_cast<std::uint32_t>(offset)};
  return static_cast<std::uint32_t>(offset);
}

std::size_t MeshReader::shown() const {
  std::set<int> meshes;
  for (const auto& [key, index] : known_) meshes.insert(std::get<0>(key));
  return meshes.size();
}

}  // namespace sightline::gltf
