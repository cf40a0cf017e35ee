#include "core/import/gltf_thinning.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "core/import/refusal.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// Sizes of the sections, which references are held against.
struct Counts {
  std::size_t nodes = 0, meshes = 0, accessors = 0, views = 0, buffers = 0;
};

void check_version(json& root, JsonChecker& check, const Place& file) {
  json* asset = check.object(root, "asset", file);
  const Place at = file.member("asset");
  if (asset == nullptr) return check.refuse(at, "is missing");
  for (const char* key : {"version", "minVersion"}) {
    const auto found = asset->find(key);
    if (found == asset->end()) {
      if (key[0] == 'v') check.refuse(at.member(key), "is missing");
      continue;
    }
    if (!found->is_string()) return check.refuse(at.member(key), "must be a string");
    const std::string& version = found->get_ref<const std::string&>();
    if (version.rfind("2.", 0) == 0 && (key[0] == 'v' || version == "2.0")) continue;
    check.refuse(
        Error{ErrorKind::kUnsupported, "GLTF_VERSION_UNSUPPORTED",
              at.member(key).text() + " is \"" + shortened(version) + "\", only 2.0 can be read",
              at.member(key).pointer()});
  }
}

/// Extensions that leave every position where it is, next to those that this room applies.
bool known_extension(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kHarmless = {
      "KHR_lights_punctual",   "KHR_xmp",
      "KHR_xmp_json_ld",       "KHR_texture_basisu",
      "KHR_texture_transform", "KHR_animation_pointer",
      "MSFT_texture_dds",      "EXT_texture_webp",
      "EXT_texture_avif"};
  if (name == kQuantization || name == kInstancing) return true;
  return name.rfind("KHR_materials_", 0) == 0 ||
         std::find(kHarmless.begin(), kHarmless.end(), name) != kHarmless.end();
}

void check_extensions(json& root, GltfDocument& document, JsonChecker& check, const Place& file) {
  for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
    json* list = check.array(root, key, file);
    if (list == nullptr) continue;
    const Place at = file.member(key);
    for (std::size_t i = 0; i < list->size(); ++i) {
      const Place element = at.element(i);
      if (!(*list)[i].is_string()) return check.refuse(element, "must be a string");
      const std::string& name = (*list)[i].get_ref<const std::string&>();
      if (name == kQuantization) document.quantization = true;
      if (key == std::string_view("extensionsRequired") && !known_extension(name)) {
        check.refuse(Error{
            ErrorKind::kUnsupported, "GLTF_EXTENSION_UNSUPPORTED",
            "the file requires the extension " + shortened(name) + ", which is not known here",
            element.pointer()});
      }
    }
  }
}

/// A section of objects, or nullptr.
json* section(json& root, const char* key, JsonChecker& check, const Place& file) {
  json* list = check.array(root, key, file);
  if (list == nullptr) return nullptr;
  const Place at = file.member(key);
  for (std::size_t i = 0; i < list->size(); ++i) {
    if (!check.is_object((*list)[i], at.element(i))) return nullptr;
  }
  return list;
}

/// Keeps of "extensions" what `name` says and returns it when present.
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

void take_materials(json* list, GltfDocument& document, JsonChecker& check, const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    check.text(object, "name", at.element(i));
    check.boolean(object, "doubleSided", at.element(i));
    if (!check.good()) return;
    document.materials.push_back(
        {object.value("name", std::string()), object.value("doubleSided", false)});
  }
}

void thin_views(json* list, const Counts& counts, JsonChecker& check, const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    if (only_extension(object, kMeshopt, check, place) != nullptr) {
      object["extensions"][kMeshopt] = json::object();
    }
    JsonChecker::keep_only(object,
                           {"buffer", "byteOffset", "byteLength", "byteStride", "extensions"});
    if (!check.reference(object, "buffer", place, counts.buffers, "buffers")) {
      check.refuse(place.member("buffer"), "is missing");
    }
    check.integer(object, "byteOffset", place);
    if (check.required_integer(object, "byteLength", place) == 0) {
      check.refuse(place.member("byteLength"), "must be at least 1");
    }
    if (const auto stride = check.integer(object, "byteStride", place, 252)) {
      if (*stride < 4 || *stride % 4 != 0) {
        check.refuse(place.member("byteStride"),
                     "must be a multiple of 4 from 4 to 252, it is " + std::to_string(*stride));
      }
    }
  }
}

void thin_sparse(json& accessor, const Counts& counts, JsonChecker& check, const Place& at) {
  json* sparse = check.object(accessor, "sparse", at);
  if (sparse == nullptr) return;
  const Place place = at.member("sparse");
  JsonChecker::keep_only(*sparse, {"count", "indices", "values"});
  // tinygltf keeps these numbers as int.
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

void thin_accessors(json* list, const Counts& counts, JsonChecker& check, const Place& at) {
  if (list == nullptr) return;
  static constexpr std::array<std::string_view, 7> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                                             "MAT2",   "MAT3", "MAT4"};
  static constexpr std::array<std::uint64_t, 6> kComponents = {5120, 5121, 5122, 5123, 5125, 5126};
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    JsonChecker::keep_only(object, {"bufferView", "byteOffset", "componentType", "count", "type",
                                    "normalized", "sparse", "min", "max"});
    if (!check.reference(object, "bufferView", place, counts.views, "bufferViews")) {
      object["bufferView"] = counts.views;  // GltfDocument::absent_view
    }
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
    check.numbers(object, "min", place, 0);
    check.numbers(object, "max", place, 0);
    thin_sparse(object, counts, check, place);
  }
}

void thin_primitive(json& object, const Counts& counts, std::size_t mesh, GltfDocument& document,
                    JsonChecker& check, const Place& at) {
  json* attributes = check.object(object, "attributes", at);
  if (attributes == nullptr) return check.refuse(at.member("attributes"), "is missing");
  if (only_extension(object, kDraco, check, at) != nullptr) {
    object["extensions"][kDraco] = json::object();
  }
  JsonChecker::keep_only(object,
                         {"attributes", "indices", "mode", "material", "targets", "extensions"});
  JsonChecker::keep_only(*attributes, {"POSITION"});
  const Place positions = at.member("attributes");
  check.reference(*attributes, "POSITION", positions, counts.accessors, "accessors");
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
    const Place list = at.member("targets");
    for (std::size_t i = 0; i < targets->size(); ++i) {
      const Place target = list.element(i);
      if (!check.is_object((*targets)[i], target)) return;
      JsonChecker::keep_only((*targets)[i], {"POSITION"});
      check.reference((*targets)[i], "POSITION", target, counts.accessors, "accessors");
    }
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
      thin_primitive((*primitives)[k], counts, i, document, check, part);
    }
  }
}

void thin_instancing(json& node, const Counts& counts, JsonChecker& check, const Place& at) {
  json* instancing = only_extension(node, kInstancing, check, at);
  if (instancing == nullptr) return;
  const Place extensions = at.member("extensions"), place = extensions.member(kInstancing);
  JsonChecker::keep_only(*instancing, {"attributes"});
  json* attributes = check.object(*instancing, "attributes", place);
  if (attributes == nullptr) return check.refuse(place.member("attributes"), "is missing");
  JsonChecker::keep_only(*attributes, {"TRANSLATION", "ROTATION", "SCALE"});
  const Place list = place.member("attributes");
  for (const char* key : {"TRANSLATION", "ROTATION", "SCALE"}) {
    check.reference(*attributes, key, list, counts.accessors, "accessors");
  }
}

void thin_nodes(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    thin_instancing(object, counts, check, place);
    JsonChecker::keep_only(object, {"name", "children", "mesh", "skin", "matrix", "translation",
                                    "rotation", "scale", "weights", "extensions"});
    check.text(object, "name", place);
    check.reference(object, "mesh", place, counts.meshes, "meshes");
    if (const auto skin = check.integer(object, "skin", place);
        skin.has_value() && *skin >= document.skin_count) {
      document.warnings.push_back("node " + std::to_string(i) + ": skin " + std::to_string(*skin) +
                                  " does not exist, the file has " +
                                  std::to_string(document.skin_count));
      object.erase("skin");
    }
    check.numbers(object, "matrix", place, 16);
    check.numbers(object, "translation", place, 3);
    check.numbers(object, "rotation", place, 4);
    check.numbers(object, "scale", place, 3);
    check.numbers(object, "weights", place, 0);
    if (object.contains("matrix") && (object.contains("translation") ||
                                      object.contains("rotation") || object.contains("scale"))) {
      check.refuse(place, "has both a matrix and translation, rotation or scale");
    }
    if (json* children = check.array(object, "children", place)) {
      const Place listed = place.member("children");
      for (std::size_t k = 0; k < children->size() && check.good(); ++k) {
        check.reference((*children)[k], listed.element(k), counts.nodes, "nodes");
      }
    }
  }
}

/// Leaves the one scene to load as the only one, or none when the file has none.
void choose_scene(json& root, json* list, const ImportOptions& options, const Counts& counts,
                  GltfDocument& document, JsonChecker& check, const Place& file) {
  const std::size_t count = list != nullptr ? list->size() : 0;
  const auto stated = check.reference(root, "scene", file, count, "scenes");
  if (!check.good()) return;
  if (options.scene.has_value() && *options.scene >= count) {
    return check.refuse(invalid("GLTF_SCENE_UNKNOWN", "scene " + std::to_string(*options.scene) +
                                                          " was asked for, the file has " +
                                                          std::to_string(count)));
  }
  root.erase("scene");
  if (count == 0) {
    document.warnings.emplace_back("the file has no scenes: all root nodes were loaded");
    root.erase("scenes");
    return;
  }
  const std::size_t chosen = options.scene.has_value() ? *options.scene : stated.value_or(0);
  const Place scenes = file.member("scenes"), place = scenes.element(chosen);
  json scene = std::move((*list)[chosen]);
  JsonChecker::keep_only(scene, {"name", "nodes"});
  check.text(scene, "name", place);
  if (json* nodes = check.array(scene, "nodes", place)) {
    const Place listed = place.member("nodes");
    for (std::size_t k = 0; k < nodes->size() && check.good(); ++k) {
      check.reference((*nodes)[k], listed.element(k), counts.nodes, "nodes");
    }
  }
  document.has_scene = true;
  root["scenes"] = json::array({std::move(scene)});
}

}  // namespace

void thin_gltf(json& root, const ImportOptions& options, GltfDocument& document,
               JsonChecker& check) {
  const Place file;
  if (!root.is_object()) return check.refuse(file.member("the file"), "must be a JSON object");
  check_version(root, check, file);
  check_extensions(root, document, check, file);
  JsonChecker::keep_only(root, {"asset", "scene", "scenes", "nodes", "meshes", "accessors",
                                "bufferViews", "buffers", "materials", "skins"});

  json* nodes = section(root, "nodes", check, file);
  json* meshes = section(root, "meshes", check, file);
  json* accessors = section(root, "accessors", check, file);
  json* views = section(root, "bufferViews", check, file);
  json* buffers = section(root, "buffers", check, file);
  json* materials = section(root, "materials", check, file);
  json* skins = section(root, "skins", check, file);
  json* scenes = section(root, "scenes", check, file);
  if (!check.good()) return;

  const auto size = [](const json* list) { return list != nullptr ? list->size() : 0; };
  const Counts counts = {size(nodes), size(meshes), size(accessors), size(views), size(buffers)};
  document.skin_count = size(skins);
  document.absent_view = static_cast<int>(counts.views);
  if (counts.nodes > options.limits.nodes) {
    return check.refuse(
        beyond_limit("NODES", "nodes", counts.nodes, options.limits.nodes, "/nodes"));
  }
  choose_scene(root, scenes, options, counts, document, check, file);
  take_buffers(buffers, document, check, file.member("buffers"));
  take_materials(materials, document, check, file.member("materials"));
  thin_views(views, counts, check, file.member("bufferViews"));
  thin_accessors(accessors, counts, check, file.member("accessors"));
  thin_meshes(meshes, counts, document, check, file.member("meshes"));
  thin_nodes(nodes, counts, document, check, file.member("nodes"));

  JsonChecker::keep_only(root, {"asset", "scenes", "nodes", "meshes", "accessors", "bufferViews"});
  if (json* asset = check.object(root, "asset", file)) JsonChecker::keep_only(*asset, {"version"});
}

}  // namespace sightline::gltf
