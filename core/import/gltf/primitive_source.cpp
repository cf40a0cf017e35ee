#include "core/import/gltf/primitive_source.h"

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

Error wrong_accessor(int accessor, const std::string& place, const std::string& what) {
  return invalid("GLTF_ACCESSOR_INVALID",
                 place + ": accessor " + std::to_string(accessor) + " " + what,
                 "/accessors/" + std::to_string(accessor));
}

/// Indices as the decoder made them, whatever type their accessor states.
AccessorView corners_view(const DracoMesh& decoded, int accessor) {
  AccessorView view;
  view.accessor = static_cast<std::uint32_t>(accessor);
  view.count = decoded.corners.size();
  view.component = Component::kU32;
  view.base = reinterpret_cast<const std::byte*>(decoded.corners.data());
  view.stride = sizeof(std::uint32_t);
  view.is_decoded = true;
  return view;
}

/// nullptr: the attribute is not among the compressed ones.
const DecodedElements* decoded_attribute(const PrimitiveSource& found, const DracoEntry* draco,
                                         const std::string& name) {
  if (draco == nullptr) return nullptr;
  const auto id = draco->attributes.find(name);
  return id != draco->attributes.end() ? &found.decoded->attributes.at(id->second) : nullptr;
}

bool are_joints(const AccessorView& view) {
  return view.components == 4 && !view.normalized &&
         (view.component == Component::kU8 || view.component == Component::kU16);
}

bool are_weights(const AccessorView& view) {
  if (view.components != 4) return false;
  return view.component == Component::kF32 ||
         (view.normalized &&
          (view.component == Component::kU8 || view.component == Component::kU16));
}

}  // namespace

std::span<const std::byte> count_vertices(const PrimitiveSource& found, const CornerRange& range,
                                          AccessorReader& accessors) {
  const auto positions =
      accessors.count(found.positions, range.low, range.count(), &TouchedBytes::positions);
  for (const WeightedTarget& target : found.targets) {
    accessors.announce(target.deltas, range.low, range.count(), &TouchedBytes::poses);
  }
  for (const InfluenceSet& set : found.skinning.sets) {
    accessors.announce(set.joints, range.low, range.count(), &TouchedBytes::poses);
    accessors.announce(set.weights, range.low, range.count(), &TouchedBytes::poses);
  }
  return positions;
}

Result<PrimitiveSource> PrimitiveSources::find(std::size_t mesh, std::size_t number,
                                               const Pose& pose) {
  const tinygltf::Primitive& source = document_.model.meshes[mesh].primitives[number];
  const std::string place =
      "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(number);
  PrimitiveSource found;
  found.place = place;
  auto unpacked = decoded(mesh, number, place);
  if (!unpacked) return unpacked.error();
  found.decoded = *std::move(unpacked);

  const int position_accessor = source.attributes.at("POSITION");
  const DracoEntry* const draco =
      found.decoded != nullptr ? &document_.draco.at({mesh, number}) : nullptr;
  auto positions =
      position_view(position_accessor, place, decoded_attribute(found, draco, "POSITION"));
  if (!positions) return positions.error();
  found.positions = *positions;
  check_stated_bounds(position_accessor, place);
  if (found.decoded != nullptr) {
    found.indices = corners_view(*found.decoded, source.indices);
  } else {
    auto indices = index_view(source.indices, place);
    if (!indices) return indices.error();
    found.indices = *indices;
  }
  auto targets = target_views(source, pose.weights, found.positions.count, place);
  if (!targets) return targets.error();
  found.targets = *std::move(targets);
  if (pose.joints != nullptr) {
    auto sets = influence_sets(source, found, draco);
    if (!sets) return sets.error();
    found.skinning = {pose.joints, *std::move(sets)};
  }
  return found;
}

Result<std::unique_ptr<const DracoMesh>> PrimitiveSources::decoded(std::size_t mesh,
                                                                   std::size_t number,
                                                                   const std::string& place) {
  using Decoded = std::unique_ptr<const DracoMesh>;
  const auto entry = document_.draco.find({mesh, number});
  const tinygltf::Primitive& source = document_.model.meshes[mesh].primitives[number];
  const auto has_bytes = [&](int accessor) {
    return document_.has_view(document_.model.accessors[static_cast<std::size_t>(accessor)]);
  };
  const int positions = source.attributes.at("POSITION");
  if (entry == document_.draco.end()) return Decoded();
  const bool has_fallback =
      has_bytes(positions) && (source.indices < 0 || has_bytes(source.indices));
  if (has_fallback && !document_.draco_required) return Decoded();
  const std::string pointer = "/meshes/" + std::to_string(mesh) + "/primitives/" +
                              std::to_string(number) + "/extensions/" + kDraco;
  if (source.mode != TINYGLTF_MODE_TRIANGLES) {
    return Error{ErrorKind::kUnsupported, "GLTF_EXTENSION_UNSUPPORTED",
                 place + ": " + kDraco + " of strips or fans cannot be read", pointer};
  }
  const auto& ids = entry->second.attributes;
  if (source.indices < 0 || ids.count("POSITION") == 0) {
    return invalid("GLTF_COMPRESSION_INVALID",
                   place + ": " + kDraco + " needs " +
                       (source.indices < 0 ? "an accessor of indices beside it" : "POSITION"),
                   pointer);
  }
  DracoClaim claim;
  claim.points = document_.model.accessors[static_cast<std::size_t>(positions)].count;
  claim.triangles = document_.model.accessors[static_cast<std::size_t>(source.indices)].count / 3;
  for (const auto& [name, id] : ids) claim.attributes.push_back(id);
  auto bytes = views_.compressed(entry->second.view);
  if (!bytes) return bytes.error();
  auto unpacked = decode_draco(*bytes, claim, budget_, place, pointer);
  if (!unpacked) return unpacked.error();
  return Decoded(std::make_unique<const DracoMesh>(*std::move(unpacked)));
}

Result<AccessorView> PrimitiveSources::attribute_view(int accessor,
                                                      const DecodedElements* decoded) {
  const auto index = static_cast<std::size_t>(accessor);
  return decoded != nullptr ? accessors_.view(index, *decoded) : accessors_.view(index);
}

Result<AccessorView> PrimitiveSources::position_view(int accessor, const std::string& place,
                                                     const DecodedElements* decoded) {
  auto view = attribute_view(accessor, decoded);
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

Result<std::optional<AccessorView>> PrimitiveSources::index_view(int accessor,
                                                                 const std::string& place) {
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

Result<std::vector<WeightedTarget>> PrimitiveSources::target_views(
    const tinygltf::Primitive& primitive, const std::vector<double>& weights, std::uint64_t count,
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
    auto view = position_view(deltas->second, target, nullptr);
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

Result<std::vector<InfluenceSet>> PrimitiveSources::influence_sets(
    const tinygltf::Primitive& primitive, const PrimitiveSource& found, const DracoEntry* draco) {
  const auto refuse = [&](const std::string& what) {
    return invalid("GLTF_SKIN_INVALID", found.place + ": " + what);
  };
  const auto find = [&](const std::string& name) {
    const auto attribute = primitive.attributes.find(name);
    return attribute != primitive.attributes.end() ? attribute->second : -1;
  };
  std::vector<InfluenceSet> sets;
  for (std::size_t n = 0;; ++n) {
    const std::string joints_name = "JOINTS_" + std::to_string(n);
    const std::string weights_name = "WEIGHTS_" + std::to_string(n);
    const int joints = find(joints_name), weights = find(weights_name);
    if (joints < 0 && weights < 0 && n > 0) return sets;
    if (joints < 0 || weights < 0) {
      return refuse("a node shows it with a skin, it has no " +
                    (joints < 0 ? joints_name : weights_name));
    }
    auto joints_view = attribute_view(joints, decoded_attribute(found, draco, joints_name));
    if (!joints_view) return joints_view.error();
    auto weights_view = attribute_view(weights, decoded_attribute(found, draco, weights_name));
    if (!weights_view) return weights_view.error();
    if (!are_joints(*joints_view)) {
      return wrong_accessor(joints, found.place,
                            "(" + joints_name + ") must be plain VEC4 of uint8 or uint16");
    }
    if (!are_weights(*weights_view)) {
      return wrong_accessor(
          weights, found.place,
          "(" + weights_name + ") must be VEC4 of float32 or of normalised uint8 or uint16");
    }
    for (const AccessorView& view : {*joints_view, *weights_view}) {
      if (view.count == found.positions.count) continue;
      return wrong_accessor(static_cast<int>(view.accessor), found.place,
                            "has " + std::to_string(view.count) + " elements, POSITION has " +
                                std::to_string(found.positions.count));
    }
    sets.push_back({*joints_view, *weights_view});
  }
}

void PrimitiveSources::check_stated_bounds(int accessor, const std::string& place) {
  // The bounds that a file states are not used, but when they cannot be right the file's maker
  // should know.
  const std::string who = place + ": accessor " + std::to_string(accessor) + " (POSITION) ";
  const StatedBounds stated = document_.stated_bounds[static_cast<std::size_t>(accessor)];
  if (stated == StatedBounds::kNone) {
    warnings_.add(who + "does not state its min and max");
  } else if (stated == StatedBounds::kCrossed) {
    warnings_.add(who + "states a min that is larger than its max");
  }
}

}  // namespace sightline::gltf
