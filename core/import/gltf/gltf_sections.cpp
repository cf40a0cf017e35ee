#include "core/import/gltf/gltf_sections.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/import/codec/draco_mesh.h"
#include "core/import/codec/meshopt_view.h"
#include "core/import/gltf/gltf_attributes.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// One of `names` by its position; `fallback` when absent.
std::size_t one_of(const json& object, const char* key, std::initializer_list<const char*> names,
                   std::optional<std::size_t> fallback, JsonChecker& check, const Place& at) {
  const auto found = object.find(key);
  if (found == object.end()) {
    if (!fallback.has_value()) check.refuse(at.member(key), "is missing");
    return fallback.value_or(0);
  }
  if (found->is_string()) {
    const auto& text = found->get_ref<const std::string&>();
    const auto* match = std::find(names.begin(), names.end(), text);
    if (match != names.end()) return static_cast<std::size_t>(match - names.begin());
    check.refuse(at.member(key), "is not known: \"" + shortened(text) + "\"");
  }
  check.refuse(at.member(key), "must be a string");
  return 0;
}

MeshoptView read_meshopt(json& object, const Counts& counts, JsonChecker& check, const Place& at) {
  MeshoptView view;
  const auto buffer = check.reference(object, "buffer", at, counts.buffers, "buffers");
  if (!buffer.has_value()) check.refuse(at.member("buffer"), "is missing");
  view.buffer = buffer.value_or(0);
  view.offset = check.integer(object, "byteOffset", at).value_or(0);
  view.length = check.required_integer(object, "byteLength", at);
  view.count = check.required_integer(object, "count", at);
  view.stride = check.required_integer(object, "byteStride", at, 256);
  view.mode = static_cast<MeshoptMode>(
      one_of(object, "mode", {"ATTRIBUTES", "TRIANGLES", "INDICES"}, std::nullopt, check, at));
  view.filter = static_cast<MeshoptFilter>(
      one_of(object, "filter", {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"}, 0, check, at));
  if (!check.good()) return view;
  if (view.length == 0 || view.count == 0) {
    check.refuse(at.member(view.length == 0 ? "byteLength" : "count"), "must be at least 1");
  }
  if (const char* broken = broken_rule(view)) check.refuse(at, broken);
  return view;
}

void thin_sparse(json& accessor, const Counts& counts, JsonChecker& check, const Place& at) {
  json* sparse = check.object(accessor, "sparse", at);
  if (sparse == nullptr) return;
  const Place place = at.member("sparse");
  JsonChecker::keep_only(*sparse, {"count", "indices", "values"});
  // tinygltf stores these numbers as int.
  constexpr std::uint64_t kMostInt = 0x7fffffff;
  if (check.required_integer(*sparse, "count", place, kMostInt) == 0) {
    check.refuse(place.member("count"), "must be at least 1");
  }
  for (const char* key : {"indices", "values"}) {
    json* part = check.object(*sparse, key, place);
    const Place part_place = place.member(key);
    if (part == nullptr) return check.refuse(part_place, "is missing");
    JsonChecker::keep_only(*part, {"bufferView", "byteOffset", "componentType"});
    if (!check.reference(*part, "bufferView", part_place, counts.views, "bufferViews")) {
      check.refuse(part_place.member("bufferView"), "is missing");
    }
    check.integer(*part, "byteOffset", part_place, kMostInt);
    if (key[0] == 'i') check.required_integer(*part, "componentType", part_place, 5126);
  }
}

/// Takes them out of the accessor: only positions have bounds that somebody asks for.
StatedBounds take_bounds(json& accessor, JsonChecker& check, const Place& at) {
  std::vector<double> bounds[2];
  for (const std::size_t i : {0u, 1u}) {
    const char* const key = i == 0 ? "min" : "max";
    check.numbers(accessor, key, at, 0);
    const auto found = accessor.find(key);
    if (found == accessor.end() || !check.good()) continue;
    if (found->size() == 3) bounds[i] = found->get<std::vector<double>>();
    accessor.erase(found);
  }
  const auto &low = bounds[0], &high = bounds[1];
  if (low.empty() || high.empty()) return StatedBounds::kNone;
  const bool crossed = low[0] > high[0] || low[1] > high[1] || low[2] > high[2];
  return crossed ? StatedBounds::kCrossed : StatedBounds::kOrdered;
}

/// Attributes of which a position depends.
bool is_geometric(const std::string& attribute) {
  return attribute == "POSITION" || attribute.rfind("JOINTS_", 0) == 0 ||
         attribute.rfind("WEIGHTS_", 0) == 0;
}

/// Erases the others, and those of skins where there is no skin; says how many.
std::size_t keep_geometric(json& attributes, bool has_skins) {
  const std::size_t before = attributes.size();
  for (auto member = attributes.begin(); member != attributes.end();) {
    const bool keep = member.key() == "POSITION" || (has_skins && is_geometric(member.key()));
    member = keep ? std::next(member) : attributes.erase(member);
  }
  return before - attributes.size();
}

DracoEntry read_draco(json& object, const Counts& counts, JsonChecker& check, const Place& at) {
  DracoEntry entry;
  const auto view = check.reference(object, "bufferView", at, counts.views, "bufferViews");
  if (!view.has_value()) check.refuse(at.member("bufferView"), "is missing");
  entry.view = view.value_or(0);
  json* attributes = check.object(object, "attributes", at);
  if (attributes == nullptr) {
    check.refuse(at.member("attributes"), "is missing");
    return entry;
  }
  const Place list = at.member("attributes");
  for (auto& [name, id] : attributes->items()) {
    if (!is_geometric(name)) continue;
    const auto number = check.integer(id, list.member(name), 0xffffffffu);
    entry.attributes[name] = static_cast<std::uint32_t>(number.value_or(0));
  }
  return entry;
}

void thin_primitive(json& object, const Counts& counts, std::size_t mesh, std::size_t number,
                    GltfDocument& document, JsonChecker& check, const Place& at) {
  json* attributes = check.object(object, "attributes", at);
  if (attributes == nullptr) return check.refuse(at.member("attributes"), "is missing");
  json* const draco = only_extension(object, kDraco, check, at);
  take_attributes(object, draco, counts, mesh, number, document, at);
  if (draco != nullptr) {
    const Place extensions = at.member("extensions");
    document.draco[{mesh, number}] = read_draco(*draco, counts, check, extensions.member(kDraco));
  }
  JsonChecker::keep_only(object, {"attributes", "indices", "mode", "material", "targets"});
  document.skipped.attributes += keep_geometric(*attributes, !document.skins.empty());
  const Place list = at.member("attributes");
  for (auto& [name, accessor] : attributes->items()) {
    check.reference(accessor, list.member(name), counts.accessors, "accessors");
  }
  check.reference(object, "indices", at, counts.accessors, "accessors");
  check.integer(object, "mode", at, 6);
  if (const auto material = check.integer(object, "material", at);
      material.has_value() && *material >= document.materials.size()) {
    document.warnings.push_back("mesh " + std::to_string(mesh) + ": material " +
                                std::to_string(*material) + " does not exist, the file has " +
                                std::to_string(document.materials.size()));
    object.erase("material");
  }
  if (json* targets = check.array(object, "targets", at)) {
    const Place listed = at.member("targets");
    for (std::size_t i = 0; i < targets->size(); ++i) {
      const Place target = listed.element(i);
      if (!check.is_object((*targets)[i], target)) return;
      JsonChecker::keep_only((*targets)[i], {"POSITION"});
      check.reference((*targets)[i], "POSITION", target, counts.accessors, "accessors");
    }
  }
}

}  // namespace

/// Retains of "extensions" what `name` says and returns it when present.
json* only_extension(json& object, const char* name, JsonChecker& check, const Place& at) {
  json* extensions = check.object(object, "extensions", at);
  if (extensions == nullptr) return nullptr;
  JsonChecker::keep_only(*extensions, {name});
  if (extensions->empty()) {
    object.erase("extensions");
    return nullptr;
  }
  return check.object(*extensions, name, at.member("extensions"));
}

void take_buffers(json* list, GltfDocument& document, JsonChecker& check, const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    BufferEntry entry;
    entry.byte_length = check.required_integer(object, "byteLength", place);
    if (entry.byte_length == 0) check.refuse(place.member("byteLength"), "must be at least 1");
    check.text(object, "uri", place);
    if (!check.good()) return;
    if (const auto uri = object.find("uri"); uri != object.end()) {
      entry.has_uri = true;
      entry.uri = std::move(uri->get_ref<std::string&>());
    }
    if (json* meshopt = only_extension(object, kMeshopt, check, place)) {
      entry.fallback_only = meshopt->value("fallback", json()) == true;
    }
    document.buffers.push_back(std::move(entry));
  }
}

void take_skins(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    SkinEntry skin;
    json* joints = check.array(object, "joints", place);
    const Place listed = place.member("joints");
    if (joints == nullptr || joints->empty()) return check.refuse(listed, "must name a node");
    for (std::size_t k = 0; k < joints->size() && check.good(); ++k) {
      check.reference((*joints)[k], listed.element(k), counts.nodes, "nodes");
      if (check.good()) skin.joints.push_back((*joints)[k].get<std::uint32_t>());
    }
    skin.inverse_binds =
        check.reference(object, "inverseBindMatrices", place, counts.accessors, "accessors");
    document.skins.push_back(std::move(skin));
  }
}

void thin_views(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    std::optional<MeshoptView> meshopt;
    if (json* extension = only_extension(object, kMeshopt, check, place)) {
      const Place extensions = place.member("extensions");
      meshopt = read_meshopt(*extension, counts, check, extensions.member(kMeshopt));
    }
    JsonChecker::keep_only(object, {"buffer", "byteOffset", "byteLength", "byteStride"});
    if (!check.reference(object, "buffer", place, counts.buffers, "buffers")) {
      check.refuse(place.member("buffer"), "is missing");
    }
    check.integer(object, "byteOffset", place);
    const std::uint64_t length = check.required_integer(object, "byteLength", place);
    if (length == 0) check.refuse(place.member("byteLength"), "must be at least 1");
    if (meshopt.has_value() && check.good()) {
      if (meshopt->decoded_bytes() != length) {
        check.refuse(place.member("byteLength"), "is " + std::to_string(length) + ", " + kMeshopt +
                                                     " decodes to " +
                                                     std::to_string(meshopt->count) + " * " +
                                                     std::to_string(meshopt->stride) + " bytes");
      }
      document.meshopt.emplace(i, *meshopt);
    }
    if (const auto stride = check.integer(object, "byteStride", place, 252)) {
      if (*stride < 4 || *stride % 4 != 0) {
        check.refuse(place.member("byteStride"),
                     "must be a multiple of 4 from 4 to 252, it is " + std::to_string(*stride));
      }
      if (meshopt.has_value() && meshopt->stride != *stride) {
        check.refuse(place.member("byteStride"), "is " + std::to_string(*stride) + ", that of " +
                                                     kMeshopt + " is " +
                                                     std::to_string(meshopt->stride));
      }
    }
  }
}

void thin_accessors(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                    const Place& at) {
  if (list == nullptr) return;
  static constexpr std::array<std::string_view, 7> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                                             "MAT2",   "MAT3", "MAT4"};
  static constexpr std::array<std::uint64_t, 6> kComponents = {5120, 5121, 5122, 5123, 5125, 5126};
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    JsonChecker::keep_only(object, {"bufferView", "byteOffset", "componentType", "count", "type",
                                    "normalized", "sparse", "min", "max"});
    check.reference(object, "bufferView", place, counts.views, "bufferViews");
    check.integer(object, "byteOffset", place);
    if (check.required_integer(object, "count", place) == 0) {
      check.refuse(place.member("count"), "must be at least 1");
    }
    const std::uint64_t component = check.required_integer(object, "componentType", place);
    if (std::find(kComponents.begin(), kComponents.end(), component) == kComponents.end()) {
      check.refuse(
          place.member("componentType"),
          "must be 5120, 5121, 5122, 5123, 5125 or 5126, it is " + std::to_string(component));
    }
    const auto type = object.find("type");
    if (type == object.end() || !type->is_string()) {
      check.refuse(place.member("type"), "must be a string");
    } else if (const std::string& name = type->get_ref<const std::string&>();
               std::find(kTypes.begin(), kTypes.end(), name) == kTypes.end()) {
      check.refuse(place.member("type"), "is not a type of glTF: \"" + shortened(name) + "\"");
    }
    check.boolean(object, "normalized", place);
    document.stated_bounds.push_back(take_bounds(object, check, place));
    thin_sparse(object, counts, check, place);
  }
}

void thin_meshes(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                 const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    JsonChecker::keep_only(object, {"name", "primitives", "weights"});
    check.text(object, "name", place);
    check.numbers(object, "weights", place, 0);
    json* primitives = check.array(object, "primitives", place);
    if (primitives == nullptr) return check.refuse(place.member("primitives"), "is missing");
    const Place parts = place.member("primitives");
    for (std::size_t k = 0; k < primitives->size() && check.good(); ++k) {
      const Place part = parts.element(k);
      if (!check.is_object((*primitives)[k], part)) return;
      thin_primitive((*primitives)[k], counts, i, k, document, check, part);
    }
  }
}

}  // namespace sightline::gltf
