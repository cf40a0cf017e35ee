#include "core/import/gltf/attribute_reader.h"

#include <cstring>

#include "core/import/codec/draco_mesh.h"
#include "core/import/codec/meshopt_view.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// A skin turns normals and tangents.
bool is_turned(VertexAttribute attribute, const Pose& pose) {
  return pose.joints != nullptr &&
         (attribute == VertexAttribute::kNormal || attribute == VertexAttribute::kTangent);
}

}  // namespace

void AttributeReader::append(const PrimitiveSource& found, const Pose& pose,
                             const CornerRange& range, std::uint32_t first_vertex, Mesh& mesh) {
  const std::pair<std::size_t, std::size_t> primitive{mesh.file_mesh,
                                                      mesh.primitives.back().file_primitive};
  const auto entry = document_.attributes.find(primitive);
  if (entry == document_.attributes.end() || (shared_.owner == nullptr && !copies_)) return;
  PrimitiveAttributes attributes;
  std::shared_ptr<const SkinTurn> skin;
  attributes.first_vertex = first_vertex;
  for (const AttributeEntry& each : entry->second) {
    const Wanted wanted{each, entry->second, primitive, found, range, each.accessor};
    auto numbers = find(wanted);
    if (numbers && *numbers != nullptr) numbers = posed(wanted, pose, *std::move(numbers), skin);
    if (!numbers) {
      warnings_.add(found.place + ": " + std::string(document_.name_of(each.attribute)) +
                    " was left out: " + numbers.error().message);
    } else if (*numbers != nullptr) {
      attributes.entries.push_back({each.attribute, *std::move(numbers)});
    }
  }
  if (attributes.entries.empty()) return;
  mesh.attributes.resize(mesh.primitives.size());
  mesh.attributes.back() = std::move(attributes);
}

Result<AttributeReader::Numbers> AttributeReader::posed(const Wanted& wanted, const Pose& pose,
                                                        Numbers numbers,
                                                        std::shared_ptr<const SkinTurn>& skin) {
  std::vector<std::pair<double, Numbers>> targets;
  const std::vector<int>& added_by = wanted.entry.targets;
  for (std::size_t k = 0; k < pose.weights.size() && k < added_by.size(); ++k) {
    const int accessor = added_by[k];
    if (pose.weights[k] == 0 || accessor == -1) continue;
    // Without what moves it, it would be another attribute.
    if (accessor == AttributeEntry::kUnusable) return Numbers();
    Wanted added = wanted;
    added.accessor = accessor;
    added.is_added = true;
    auto found = find(added);
    if (!found || *found == nullptr) return found;
    targets.emplace_back(pose.weights[k], *std::move(found));
  }
  const bool turned = is_turned(wanted.entry.attribute, pose), is_shared = skin != nullptr;
  if (turned && !is_shared) {
    auto found = skin_of(wanted.found, wanted.range);
    if (!found) return std::move(found).error();
    if (*found == nullptr) return Numbers();
    skin = *std::move(found);
  }
  if (targets.empty() && !turned) return numbers;
  return Numbers(std::make_shared<const PosedNumbers>(wanted.entry.attribute, std::move(numbers),
                                                      std::move(targets), turned ? skin : nullptr,
                                                      is_shared));
}

Result<std::shared_ptr<const SkinTurn>> AttributeReader::skin_of(const PrimitiveSource& found,
                                                                 const CornerRange& range) {
  using Turn = std::shared_ptr<const SkinTurn>;
  std::shared_ptr<const JointMatrices>& joints = joints_[found.skinning.joints];
  if (joints == nullptr) {
    const std::uint64_t bytes = found.skinning.joints->size() * sizeof(Affine);
    if (Status status = budget_.spend_bytes(bytes); !status) return std::move(status).error();
    joints = std::make_shared<const JointMatrices>(*found.skinning.joints);
  }
  SkinTurn turn;
  turn.joints = joints;
  for (const InfluenceSet& set : found.skinning.sets) {
    auto numbers = keep(set.joints, range), weights = keep(set.weights, range);
    if (!numbers) return std::move(numbers).error();
    if (!weights) return std::move(weights).error();
    if (*numbers == nullptr || *weights == nullptr) return Turn();
    turn.sets.push_back({*std::move(numbers), *std::move(weights)});
  }
  return Turn(std::make_shared<const SkinTurn>(std::move(turn)));
}

Result<AttributeReader::Numbers> AttributeReader::find(const Wanted& wanted) {
  const auto index = static_cast<std::size_t>(wanted.accessor);
  const auto& accessor = document_.model.accessors[index];
  const auto& draco = wanted.entry.draco;
  const bool is_compressed = wanted.found.decoded != nullptr && !wanted.is_added;
  if (is_compressed && draco.has_value()) return find_draco(wanted, *draco);
  if (is_compressed && !document_.has_view(accessor)) {
    return invalid("GLTF_COMPRESSION_INVALID", "it is neither in the file nor compressed");
  }
  if (!is_at_hand(index)) {
    return invalid("GLTF_BUFFER_INVALID", "accessor " + std::to_string(index) +
                                              " lies in a buffer that no geometry needs");
  }
  if (document_.has_view(accessor)) {
    const auto view = static_cast<std::size_t>(accessor.bufferView);
    if (views_.is_meshopt(view)) return find_meshopt(wanted, view);
  }
  return find_stored(wanted);
}

bool AttributeReader::is_at_hand(std::size_t index) const {
  const auto& accessor = document_.model.accessors[index];
  const auto has = [&](int view) { return views_.is_at_hand(static_cast<std::size_t>(view)); };
  if (document_.has_view(accessor) && !has(accessor.bufferView)) return false;
  return !accessor.sparse.isSparse ||
         (has(accessor.sparse.indices.bufferView) && has(accessor.sparse.values.bufferView));
}

/// [glTF2] 3.7.2.1, and KHR_mesh_quantization where the file has it.
bool AttributeReader::is_of_its_type(const Wanted& wanted, const AccessorView& view) const {
  const bool is_small = view.component != Component::kF32 && view.component != Component::kU32;
  const bool is_number = view.component == Component::kF32 || (is_small && view.normalized);
  const VertexAttribute attribute = wanted.entry.attribute;
  switch (attribute) {
    case VertexAttribute::kNormal:
      return view.components == 3 && is_number;
    case VertexAttribute::kTangent:
      // A morph target does not add to the sign.
      return view.components == (wanted.is_added ? 3u : 4u) && is_number;
    case VertexAttribute::kUv:
    case VertexAttribute::kUv1:
      return view.components == 2 && (is_number || (is_small && document_.quantization));
    case VertexAttribute::kColour:
      return (view.components == 3 || view.components == 4) && is_number;
    default:
      break;
  }
  // One that the file names is of any component type, but has as many numbers in every primitive.
  const auto& accessors = document_.model.accessors;
  const NamedEntry& first = document_.named.list[named_index(attribute)];
  return view.components <= 4 && accessors[view.accessor].type == accessors[first.accessor].type;
}

Status AttributeReader::check(const Wanted& wanted, const AccessorView& view) const {
  const auto wrong = [&](const std::string& what) {
    return invalid("GLTF_ACCESSOR_INVALID",
                   "accessor " + std::to_string(view.accessor) + " " + what);
  };
  if (!is_of_its_type(wanted, view)) {
    return wrong("is of another type than its attribute has");
  }
  if (view.count != wanted.found.positions.count) {
    return wrong("has " + std::to_string(view.count) + " elements, POSITION has " +
                 std::to_string(wanted.found.positions.count));
  }
  return success();
}

Result<AttributeReader::Numbers> AttributeReader::find_stored(const Wanted& wanted) {
  auto view = accessors_.view(static_cast<std::size_t>(wanted.accessor));
  if (!view) return view.error();
  if (Status status = check(wanted, *view); !status) return status.error();
  return keep(*view, wanted.range);
}

Result<AttributeReader::Numbers> AttributeReader::keep(const AccessorView& view,
                                                       const CornerRange& range) {
  if (is_kept(view)) {
    return Numbers(std::make_shared<const StoredNumbers>(view, 0, shared_.owner, 0));
  }
  return copies_ ? copy(view, range) : Numbers();
}

bool AttributeReader::is_kept(const AccessorView& view) const {
  const std::size_t element = view.element_bytes();
  if (view.base != nullptr && !is_held({view.base, (view.count - 1) * view.stride + element})) {
    return false;
  }
  return view.sparse_count == 0 ||
         (is_held(
              {view.sparse_indices, view.sparse_count * component_bytes(view.sparse_component)}) &&
          is_held({view.sparse_values, view.sparse_count * element}));
}

Result<AttributeReader::Numbers> AttributeReader::copy(const AccessorView& view,
                                                       const CornerRange& range) {
  const std::uint64_t count = std::uint64_t{range.high} - range.low + 1;
  const std::size_t element = view.element_bytes();
  if (Status status = budget_.spend_bytes(count * element); !status) return status.error();
  accessors_.announce(view, range.low, count, &TouchedBytes::attributes);
  const auto bytes = std::make_shared<std::vector<std::byte>>(count * element);
  for (std::uint64_t i = 0; i < count && view.base != nullptr; ++i) {
    std::memcpy(bytes->data() + i * element, view.base + (range.low + i) * view.stride, element);
  }
  for (std::uint64_t k = sparse_lower_bound(view, range.low); k < view.sparse_count; ++k) {
    const std::uint64_t at = sparse_index(view, k);
    if (at > range.high) break;
    std::memcpy(bytes->data() + (at - range.low) * element, view.sparse_values + k * element,
                element);
  }
  AccessorView packed = view;
  packed.count = count;
  packed.base = bytes->data();
  packed.stride = element;
  packed.sparse_count = 0;
  return Numbers(std::make_shared<const StoredNumbers>(packed, range.low, bytes, count * element));
}

Result<std::optional<SharedColumn<std::byte>>> AttributeReader::hold(
    std::span<const std::byte> compressed) {
  using Held = std::optional<SharedColumn<std::byte>>;
  if (is_held(compressed)) {
    return Held(shared_.share<std::byte>(compressed.data(), compressed.size()));
  }
  if (!copies_) return Held();
  if (Status status = budget_.spend_bytes(compressed.size()); !status) return status.error();
  return Held(UnsetColumn<std::byte>(compressed.begin(), compressed.end()));
}

Result<AttributeReader::Numbers> AttributeReader::find_meshopt(const Wanted& wanted,
                                                               std::size_t number) {
  const auto index = static_cast<std::size_t>(wanted.accessor);
  const auto& accessor = document_.model.accessors[index];
  if (accessor.sparse.isSparse) {
    return invalid("GLTF_ACCESSOR_INVALID", "compressed elements cannot be sparse");
  }
  auto view = accessors_.view_to_decode(index);
  if (!view) return view.error();
  if (Status status = check(wanted, *view); !status) return status.error();
  std::shared_ptr<const LateView>& late = late_views_[number];
  if (late == nullptr) {
    auto compressed = views_.to_decode(number);
    if (!compressed) return compressed.error();
    auto held = hold(*compressed);
    if (!held) return held.error();
    if (!held->has_value()) return Numbers();
    late = std::make_shared<const LateView>(
        **std::move(held), !is_held(*compressed),
        [description = document_.meshopt.at(number)](std::span<const std::byte> bytes) {
          return decode_meshopt(description, bytes, "an attribute", "");
        });
  }
  const auto begin = [late, offset = accessor.byteOffset](std::uint64_t& touched) {
    const auto* const bytes = late->get(touched);
    return bytes != nullptr ? bytes->get() + offset : nullptr;
  };
  return Numbers(std::make_shared<const LateNumbers>(*view, begin, late->bytes()));
}

Result<AttributeReader::Numbers> AttributeReader::find_draco(const Wanted& wanted,
                                                             std::uint32_t id) {
  const auto index = static_cast<std::size_t>(wanted.accessor);
  auto view = accessors_.view_of_decoded(index);
  if (!view) return view.error();
  if (Status status = check(wanted, *view); !status) return status.error();
  std::shared_ptr<const LateDraco>& late = late_draco_[wanted.primitive];
  if (late == nullptr) {
    auto compressed = views_.bytes(document_.draco.at(wanted.primitive).view);
    if (!compressed) return compressed.error();
    auto held = hold(*compressed);
    if (!held) return held.error();
    if (!held->has_value()) return Numbers();
    DracoClaim claim;
    claim.points = wanted.found.positions.count;
    claim.triangles = wanted.found.indices->count / 3;
    for (const AttributeEntry& each : wanted.all) {
      if (each.draco) claim.attributes.push_back(*each.draco);
    }
    late = std::make_shared<const LateDraco>(
        **std::move(held), !is_held(*compressed),
        [claim, limits = limits_](std::span<const std::byte> bytes) {
          Budget budget(limits);
          auto mesh = decode_draco(bytes, claim, budget, "an attribute", "");
          if (mesh) mesh->corners = {};  // they are the mesh's already
          return mesh;
        });
  }
  const auto begin = [late, id, layout = *view](std::uint64_t& touched) -> const std::byte* {
    const DracoMesh* const mesh = late->get(touched);
    if (mesh == nullptr) return nullptr;
    const DecodedElements& elements = mesh->attributes.at(id);
    const bool is_as_stated = elements.component == layout.component &&
                              elements.components == layout.components &&
                              elements.bytes.size() == layout.count * layout.stride;
    return is_as_stated ? elements.bytes.data() : nullptr;
  };
  return Numbers(std::make_shared<const LateNumbers>(*view, begin, late->bytes()));
}

}  // namespace sightline::gltf
