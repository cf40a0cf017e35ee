#include "core/import/mesh_reader.h"

#include <algorithm>
#include <limits>
#include <set>

#include "core/import/positions.h"
#include "core/import/refusal.h"
#include "core/import/unhittable.h"

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
  auto mesh = read(static_cast<std::size_t>(node.mesh), pose);
  if (!mesh) return mesh.error();
  std::optional<std::uint32_t> index;
  if (!mesh->primitives.empty()) {
    count_triangles(*mesh);
    index = static_cast<std::uint32_t>(scene_.meshes.size());
    scene_.meshes.push_back(std::make_shared<const Mesh>(*std::move(mesh)));
  }
  known_.emplace(key, index);
  return index;
}

Result<Mesh> MeshReader::read(std::size_t index, const Pose& pose) {
  const tinygltf::Mesh& source = document_.model.meshes[index];
  Mesh mesh;
  mesh.name = source.name;
  mesh.file_mesh = static_cast<std::uint32_t>(index);
  LoadedParts loaded;
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    if (Status status = append_primitive(i, pose, mesh, loaded); !status) return status.error();
  }
  mesh.indices.forget_sequence();
  return mesh;
}

Status MeshReader::append_primitive(std::size_t number, const Pose& pose, Mesh& mesh,
                                    LoadedParts& loaded) {
  const tinygltf::Primitive& source = document_.model.meshes[mesh.file_mesh].primitives[number];
  const auto attribute = source.attributes.find("POSITION");
  const bool has_triangles = source.mode >= TINYGLTF_MODE_TRIANGLES;
  if (!has_triangles || attribute == source.attributes.end()) {
    ++scene_.counts.skipped_primitives;
    return success();
  }
  const std::string place =
      "mesh " + std::to_string(mesh.file_mesh) + ", primitive " + std::to_string(number);
  // What it has, before anything is allocated for it.
  auto found = sources_.find(mesh.file_mesh, number, pose);
  if (!found) return found.error();
  const AccessorView& base = found->positions;
  const std::optional<AccessorView>& indices = found->indices;
  const std::uint64_t listed = indices.has_value() ? indices->count : base.count;
  const std::uint64_t triangles = triangle_count(source.mode, listed);
  if (triangles == 0 || (source.mode == TINYGLTF_MODE_TRIANGLES && listed % 3 != 0)) {
    warnings_.add(place + ": " + std::to_string(listed) + " vertices make " +
                  std::to_string(triangles) + " whole triangles");
    if (triangles == 0) return success();
  }
  if (triangles > budget_.triangles() || triangles + mesh.indices.size() / 3 > kMostTriangles) {
    return beyond_limit("TRIANGLES", place + ": triangles so far", budget_.with(triangles),
                        std::min(limits_.triangles, kMostTriangles));
  }
  budget_.spend_triangles(triangles);
  if (Status status = budget_.spend_bytes(triangles * 3 * sizeof(std::uint32_t)); !status)
    return status;

  // Corners first: they say which range of vertices is worth reading.
  const std::size_t first_corner = mesh.indices.size();
  if (indices.has_value()) accessors_.announce(*indices, 0, listed, &TouchedBytes::indices);
  auto range = read_corners(indices, base.count, source.mode, place, mesh);
  if (!range) return range.error();
  auto offset = append_positions(source, *found, *range, mesh, loaded);
  if (!offset) return offset.error();
  if (*offset != range->low) {
    UnsetColumn<std::uint32_t>& corners = mesh.indices.own();
    for (std::size_t i = first_corner; i < corners.size(); ++i) {
      corners[i] = corners[i] - range->low + *offset;
    }
  }
  Primitive primitive;
  primitive.first_triangle = static_cast<std::uint32_t>(first_corner / 3);
  primitive.triangle_count = static_cast<std::uint32_t>(triangles);
  primitive.file_primitive = static_cast<std::uint32_t>(number);
  if (source.material >= 0) primitive.material = static_cast<std::uint32_t>(source.material);
  mesh.primitives.push_back(primitive);
  attributes_.append(*found, pose, *range, range->low - *offset, mesh);
  return success();
}

Result<CornerRange> MeshReader::read_corners(const std::optional<AccessorView>& indices,
                                             std::uint64_t vertex_count, int mode,
                                             const std::string& place, Mesh& mesh) const {
  const bool alone = document_.model.meshes[mesh.file_mesh].primitives.size() == 1;
  if (alone && !indices.has_value() && mode == TINYGLTF_MODE_TRIANGLES) {
    const auto used = static_cast<std::uint32_t>(vertex_count / 3 * 3);
    mesh.indices = IndexColumn::sequence(used);
    return CornerRange{0, used - 1};
  }
  if (alone && indices.has_value() && mode == TINYGLTF_MODE_TRIANGLES) {
    SharedColumn<std::uint32_t> shared;
    auto range = share_corners(*indices, vertex_count, place, kept_, shared);
    if (!range) return range.error();
    if (range->has_value()) {
      mesh.indices = std::move(shared);
      return **range;
    }
  }
  return append_corners(indices, vertex_count, mode, place, mesh.indices.own());
}

SharedColumn<Vec3f> MeshReader::shared_positions(const PrimitiveSource& found,
                                                 const CornerRange& range) const {
  const AccessorView& view = found.positions;
  const bool plain = view.plain_float() && view.base != nullptr && view.stride == sizeof(Vec3f) &&
                     found.targets.empty() && found.skinning.sets.empty();
  if (!plain) return {};
  return kept_.share<Vec3f>(view.base + std::size_t{range.low} * sizeof(Vec3f),
                            std::size_t{range.high} - range.low + 1);
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
  const std::uint64_t count = std::uint64_t{range.high} - range.low + 1;
  const std::uint64_t offset = mesh.positions.size();
  if (offset + count > kMostVertices) {
    return beyond_limit("GEOMETRY_BYTES", "mesh " + std::to_string(mesh.file_mesh) + ": vertices",
                        offset + count, kMostVertices);
  }
  if (Status status = budget_.spend_bytes(count * sizeof(Vec3f)); !status) return status.error();
  accessors_.announce(found.positions, range.low, count, &TouchedBytes::positions);
  for (const WeightedTarget& target : found.targets) {
    accessors_.announce(target.deltas, range.low, count, &TouchedBytes::poses);
  }
  for (const InfluenceSet& set : found.skinning.sets) {
    accessors_.announce(set.joints, range.low, count, &TouchedBytes::poses);
    accessors_.announce(set.weights, range.low, count, &TouchedBytes::poses);
  }
  if (document_.model.meshes[mesh.file_mesh].primitives.size() == 1) {
    mesh.positions = shared_positions(found, range);
    if (!mesh.positions.empty()) return 0u;
  }
  UnsetColumn<Vec3f>& positions = mesh.positions.own();
  positions.resize(offset + count);
  auto unbalanced = load_positions(found.positions, found.targets, found.skinning, range.low, count,
                                   found.place, positions.data() + offset);
  if (!unbalanced) return unbalanced.error();
  if (*unbalanced > 0) {
    warnings_.add(found.place + ": the skin's weights of " + std::to_string(*unbalanced) +
                  " vertices do not sum to 1 and were used as they stand");
  }
  if (found.decoded == nullptr)
    loaded[key] = {range.low, range.high, static_cast<std::uint32_t>(offset)};
  return static_cast<std::uint32_t>(offset);
}

std::size_t MeshReader::shown() const {
  std::set<int> meshes;
  for (const auto& [key, index] : known_) meshes.insert(std::get<0>(key));
  return meshes.size();
}

void MeshReader::count_triangles(const Mesh& mesh) {
  const Unhittable count = count_unhittable(mesh);
  scene_.counts.degenerate_triangles += count.degenerate;
  scene_.counts.nonfinite_triangles += count.nonfinite;
  if (count.nonfinite == 0) return;
  warnings_.add("mesh " + std::to_string(mesh.file_mesh) + ": " + std::to_string(count.nonfinite) +
                " triangles have a corner that is not finite and are never hit");
}

}  // namespace sightline::gltf
