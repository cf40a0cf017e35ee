#include "core/import/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/import/positions.h"
#include "core/import/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::uint64_t kMostVertices = 0xfffffffeu;   ///< of a mesh, so that an index is a u32
constexpr std::uint64_t kMostTriangles = 0x55555554u;  ///< of a mesh, so that 3 * it fits in a u32

Error wrong_accessor(int accessor, const std::string& place, const std::string& what) {
  return invalid("GLTF_ACCESSOR_INVALID",
                 place + ": accessor " + std::to_string(accessor) + " " + what,
                 "/accessors/" + std::to_string(accessor));
}

bool is_finite(const Vec3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

Result<std::optional<std::uint32_t>> MeshReader::mesh_of(const tinygltf::Node& node) {
  // A node's weights replace the mesh's; trailing zeros do not tell meshes apart.
  const tinygltf::Mesh& source = document_.model.meshes[static_cast<std::size_t>(node.mesh)];
  std::vector<double> weights = !node.weights.empty() ? node.weights : source.weights;
  while (!weights.empty() && weights.back() == 0) weights.pop_back();
  auto key = std::make_pair(node.mesh, std::move(weights));
  if (const auto found = known_.find(key); found != known_.end()) return found->second;

  auto mesh = read(static_cast<std::size_t>(node.mesh), key.second);
  if (!mesh) return mesh.error();
  std::optional<std::uint32_t> index;
  if (!mesh->primitives.empty()) {
    count_nonfinite(*mesh);
    index = static_cast<std::uint32_t>(scene_.meshes.size());
    scene_.meshes.push_back(std::make_shared<const Mesh>(*std::move(mesh)));
  }
  known_.emplace(std::move(key), index);
  return index;
}

Result<Mesh> MeshReader::read(std::size_t index, const std::vector<double>& weights) {
  const tinygltf::Mesh& source = document_.model.meshes[index];
  Mesh mesh;
  mesh.name = source.name;
  mesh.file_mesh = static_cast<std::uint32_t>(index);
  LoadedParts loaded;
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    if (Status status = append_primitive(i, weights, mesh, loaded); !status) return status.error();
  }
  return mesh;
}

Status MeshReader::append_primitive(std::size_t number, const std::vector<double>& weights,
                                    Mesh& mesh, LoadedParts& loaded) {
  const tinygltf::Primitive& source = document_.model.meshes[mesh.file_mesh].primitives[number];
  const auto attribute = source.attributes.find("POSITION");
  const bool has_triangles = source.mode >= TINYGLTF_MODE_TRIANGLES;
  if (!has_triangles || attribute == source.attributes.end()) {
    ++scene_.counts.skipped_primitives;
    return success();
  }
  const std::string place =
      "mesh " + std::to_string(mesh.file_mesh) + ", primitive " + std::to_string(number);
  const int position_accessor = attribute->second;
  if (source.extensions.count(kDraco) != 0 &&
      !document_.has_view(document_.model.accessors[static_cast<std::size_t>(position_accessor)])) {
    return Error{ErrorKind::kUnsupported, "GLTF_EXTENSION_UNSUPPORTED",
                 place + " is compressed by " + kDraco, ""};
  }

  // What it has, before anything is allocated for it.
  auto base = position_view(position_accessor, place);
  if (!base) return base.error();
  check_stated_bounds(position_accessor, place);
  auto indices = index_view(source.indices, place);
  if (!indices) return indices.error();
  auto targets = target_views(source, weights, base->count, place);
  if (!targets) return targets.error();
  const std::uint64_t listed = indices->has_value() ? (*indices)->count : base->count;
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
  if (indices->has_value()) accessors_.count_touched(**indices, listed);
  auto range = append_corners(*indices, base->count, source.mode, place, mesh.indices);
  if (!range) return range.error();
  auto offset = append_positions(source, *base, *targets, *range, mesh, loaded);
  if (!offset) return offset.error();
  if (*offset != range->low) {
    for (std::size_t i = first_corner; i < mesh.indices.size(); ++i) {
      mesh.indices[i] = mesh.indices[i] - range->low + *offset;
    }
  }
  Primitive primitive;
  primitive.first_triangle = static_cast<std::uint32_t>(first_corner / 3);
  primitive.triangle_count = static_cast<std::uint32_t>(triangles);
  primitive.file_primitive = static_cast<std::uint32_t>(number);
  if (source.material >= 0) primitive.material = static_cast<std::uint32_t>(source.material);
  mesh.primitives.push_back(primitive);
  return success();
}

Result<std::uint32_t> MeshReader::append_positions(const tinygltf::Primitive& source,
                                                   const AccessorView& base,
                                                   const std::vector<WeightedTarget>& targets,
                                                   const CornerRange& range, Mesh& mesh,
                                                   LoadedParts& loaded) {
  // Primitives of one mesh often share their vertices; what stands there already is used again.
  std::vector<int> key = {static_cast<int>(base.accessor)};
  for (const auto& target : source.targets) {
    const auto deltas = target.find("POSITION");
    key.push_back(deltas != target.end() ? deltas->second : -1);
  }
  const auto known = loaded.find(key);
  if (known != loaded.end() && known->second.low <= range.low && range.high <= known->second.high) {
    return known->second.base + (range.low - known->second.low);
  }
  const std::uint64_t count = std::uint64_t{range.high} - range.low + 1;
  const std::uint64_t offset = mesh.positions.size();
  if (offset + count > kMostVertices) {
    return beyond_limit("GEOMETRY_BYTES", "mesh " + std::to_string(mesh.file_mesh) + ": vertices",
                        offset + count, kMostVertices);
  }
  if (Status status = budget_.spend_bytes(count * sizeof(Vec3f)); !status) return status.error();
  mesh.positions.resize(offset + count);
  load_positions(base, targets, range.low, count, mesh.positions.data() + offset);
  accessors_.count_touched(base, count);
  for (const WeightedTarget& target : targets) accessors_.count_touched(target.deltas, count);
  loaded[key] = {range.low, range.high, static_cast<std::uint32_t>(offset)};
  return static_cast<std::uint32_t>(offset);
}

Result<AccessorView> MeshReader::position_view(int accessor, const std::string& place) {
  auto view = accessors_.view(static_cast<std::size_t>(accessor));
  if (!view) return view;
  if (view->components != 3) return wrong_accessor(accessor, place, "POSITION must be VEC3");
  if (view->component == Component::kU32) {
    return wrong_accessor(accessor, place, "POSITION cannot be uint32");
  }
  if (view->component != Component::kF32 && !document_.quantization) {
    return wrong_accessor(accessor, place,
                          std::string("POSITION is not float32, which needs ") + kQuantization);
  }
  if (view->count > kMostVertices) {
    return beyond_limit("GEOMETRY_BYTES", place + ": vertices", view->count, kMostVertices);
  }
  return view;
}

Result<std::optional<AccessorView>> MeshReader::index_view(int accessor, const std::string& place) {
  using Found = std::optional<AccessorView>;
  if (accessor < 0) return Found();
  auto view = accessors_.view(static_cast<std::size_t>(accessor));
  if (!view) return view.error();
  const bool is_index = view->component == Component::kU8 || view->component == Component::kU16 ||
                        view->component == Component::kU32;
  if (view->components != 1 || !is_index || view->normalized) {
    return wrong_accessor(accessor, place,
                          "indices must be plain SCALAR of uint8, uint16 or uint32");
  }
  if (view->base != nullptr && view->stride != view->element_bytes()) {
    return wrong_accessor(
        accessor, place, "indices must be packed, their stride is " + std::to_string(view->stride));
  }
  return Found(*view);
}

Result<std::vector<WeightedTarget>> MeshReader::target_views(const tinygltf::Primitive& primitive,
                                                             const std::vector<double>& weights,
                                                             std::uint64_t count,
                                                             const std::string& place) {
  std::vector<WeightedTarget> targets;
  if (weights.size() > primitive.targets.size()) {
    warnings_.add(place + ": " + std::to_string(weights.size()) + " morph weights for " +
                  std::to_string(primitive.targets.size()) + " targets");
  }
  for (std::size_t k = 0; k < primitive.targets.size() && k < weights.size(); ++k) {
    const auto deltas = primitive.targets[k].find("POSITION");
    if (weights[k] == 0 || deltas == primitive.targets[k].end()) continue;
    const std::string target = place + ", target " + std::to_string(k);
    auto view = position_view(deltas->second, target);
    if (!view) return view.error();
    if (view->count != count) {
      return wrong_accessor(deltas->second, target,
                            "has " + std::to_string(view->count) + " elements, POSITION has " +
                                std::to_string(count));
    }
    targets.push_back({*view, weights[k]});
  }
  return targets;
}

void MeshReader::check_stated_bounds(int accessor, const std::string& place) {
  // The bounds that a file states are not used, but when they cannot be right the file's maker
  // should know.
  const auto& source = document_.model.accessors[static_cast<std::size_t>(accessor)];
  const auto &low = source.minValues, &high = source.maxValues;
  const std::string who = place + ": accessor " + std::to_string(accessor) + " (POSITION) ";
  if (low.size() != 3 || high.size() != 3) {
    warnings_.add(who + "does not state its min and max");
  } else if (low[0] > high[0] || low[1] > high[1] || low[2] > high[2]) {
    warnings_.add(who + "states a min that is larger than its max");
  }
}

void MeshReader::count_nonfinite(const Mesh& mesh) {
  if (std::all_of(mesh.positions.begin(), mesh.positions.end(), is_finite)) return;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const bool finite = is_finite(mesh.positions[mesh.indices[i]]) &&
                        is_finite(mesh.positions[mesh.indices[i + 1]]) &&
                        is_finite(mesh.positions[mesh.indices[i + 2]]);
    count += finite ? 0 : 1;
  }
  if (count == 0) return;
  scene_.counts.nonfinite_triangles += count;
  warnings_.add("mesh " + std::to_string(mesh.file_mesh) + ": " + std::to_string(count) +
                " triangles have a corner that is not finite and are never hit");
}

}  // namespace sightline::gltf
