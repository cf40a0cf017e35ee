#include "core/import/gltf/gltf_thinning.h"
#include "core/import/gltf/alpha_image.h"

#include <algorithm>
#include <array>

#include "core/import/codec/draco_mesh.h"
#include "core/import/gltf/gltf_animations.h"
#include "core/import/gltf/gltf_attributes.h"
#include "core/import/gltf/gltf_cameras.h"
#include "core/import/gltf/gltf_sections.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

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
  if (name == kQuantization || name == kInstancing || name == kMeshopt || name == kDraco) {
    return true;
  }
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
      const bool is_required = key == std::string_view("extensionsRequired");
      if (name == kDraco && is_required) document.draco_required = true;
      if (is_required && !known_extension(name)) {
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

AlphaMode read_alpha_mode(const json& material, std::size_t number, GltfDocument& document) {
  const auto stated = material.value("alphaMode", std::string("OPAQUE"));
  for (const AlphaMode mode : {AlphaMode::kOpaque, AlphaMode::kMask, AlphaMode::kBlend}) {
    if (stated == alpha_mode_name(mode)) return mode;
  }
  document.warnings.push_back("material " + std::to_string(number) + ": alphaMode \"" +
                              shortened(stated) + "\" is not known and was taken for OPAQUE");
  return AlphaMode::kOpaque;
}

std::array<double, 4> read_base_colour(const json& material, std::size_t number,
                                       GltfDocument& document) {
  std::array<double, 4> colour = {1, 1, 1, 1};
  const auto metallic = material.find("pbrMetallicRoughness");
  if (metallic == material.end() || !metallic->is_object()) return colour;
  const auto factor = metallic->find("baseColorFactor");
  if (factor == metallic->end()) return colour;
  const bool good =
      factor->is_array() && factor->size() == 4 &&
      std::all_of(factor->begin(), factor->end(), [](const json& x) { return x.is_number(); });
  for (std::size_t k = 0; good && k < 4; ++k) colour[k] = (*factor)[k].get<double>();
  if (!good) {
    document.warnings.push_back("material " + std::to_string(number) +
                                ": baseColorFactor is not four numbers and was left out");
  }
  return colour;
}

/// Whether light passes through the material by KHR_materials_transmission.
bool reads_transmission(const json& material) {
  const json* at = &material;
  for (const char* key : {"extensions", "KHR_materials_transmission", "transmissionFactor"}) {
    const auto found = at->find(key);
    if (found == at->end()) return false;
    at = &*found;
    if (!at->is_object()) break;
  }
  return at->is_number() && at->get<double>() > 0;
}

void take_materials(json* list, GltfDocument& document, JsonChecker& check, const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    check.text(object, "name", at.element(i));
    check.boolean(object, "doubleSided", at.element(i));
    check.text(object, "alphaMode", at.element(i));
    if (!check.good()) return;
    document.materials.push_back(
        {object.value("name", std::string()), object.value("doubleSided", false),
         read_alpha_mode(object, i, document), read_base_colour(object, i, document),
         reads_transmission(object)});
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

/// Retains the text of the extras. Only the member "sightline" has to be as documented.
void take_extras(json& node, std::size_t number, GltfDocument& document, JsonChecker& check,
                 const Place& at) {
  const auto extras = node.find("extras");
  if (extras == node.end() || extras->is_null()) return;
  document.extras[number] = extras->dump();
  if (!extras->is_object()) return;
  const auto own = extras->find("sightline");
  if (own == extras->end() || !own->is_object() || !own->contains("mask")) return;
  const Place place = at.member("extras");
  const auto mask = check.integer((*own)["mask"], place.member("sightline"), 0xffffffffu);
  if (mask.has_value()) document.masks[number] = static_cast<std::uint32_t>(*mask);
}

void thin_nodes(json* list, const Counts& counts, GltfDocument& document, JsonChecker& check,
                const Place& at) {
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size() && check.good(); ++i) {
    json& object = (*list)[i];
    const Place place = at.element(i);
    thin_instancing(object, counts, check, place);
    take_extras(object, i, document, check, place);
    JsonChecker::keep_only(object, {"name", "children", "mesh", "skin", "matrix", "translation",
                                    "rotation", "scale", "weights", "extensions"});
    check.text(object, "name", place);
    check.reference(object, "mesh", place, counts.meshes, "meshes");
    if (const auto skin = check.integer(object, "skin", place);
        skin.has_value() && *skin >= document.skins.size()) {
      document.warnings.push_back("node " + std::to_string(i) + ": skin " + std::to_string(*skin) +
                                  " does not exist, the file has " +
                                  std::to_string(document.skins.size()));
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

/// Leaves only the scene to load, or none when the file has none.
void choose_scene(json& root, json* list, const ImportOptions& options, const Counts& counts,
                  GltfDocument& document, JsonChecker& check, const Place& file) {
  const std::size_t count = list != nullptr ? list->size() : 0;
  const auto stated = check.reference(root, "scene", file, count, "scenes");
  if (!check.good()) return;
  if (options.scene.has_value() && *options.scene >= count) {
    return check.refuse(invalid("GLTF_SCENE_UNKNOWN", "scene " + std::to_string(*options.scene) +
                                                          " was asked for, the file has " +
                                                          std::to_string(count) +
                                                          ", counted from 0"));
  }
  root.erase("scene");
  document.skipped.scenes = count > 0 ? count - 1 : 0;
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

/// Reads nothing in it: what is wrong there is nobody's error.
void count_what_is_left_out(const json& root, const ImportOptions& options,
                            GltfDocument& document) {
  const auto list = [&](const char* key) -> const json* {
    const auto found = root.find(key);
    return found != root.end() && found->is_array() ? &*found : nullptr;
  };
  if (const json* animations = list("animations")) document.skipped.animations = animations->size();
  const json* const images = list("images");
  if (images == nullptr) return;
  document.skipped.images = images->size();
  if (options.skip) return;
  for (const json& image : *images) {
    const auto uri = image.is_object() ? image.find("uri") : image.end();
    if (uri != image.end() && uri->is_string()) {
      document.image_uris.push_back(uri->get<std::string>());
    }
  }
}

}  // namespace

void thin_gltf(json& root, const ImportOptions& options, GltfDocument& document,
               JsonChecker& check) {
  const Place file;
  if (!root.is_object()) return check.refuse(file.member("the file"), "must be a JSON object");
  check_version(root, check, file);
  check_extensions(root, document, check, file);
  count_what_is_left_out(root, options, document);
  take_cameras(root, document);
  take_animations(root, document);
  take_alpha(root, document);
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
  if (counts.nodes > options.limits.nodes) {
    return check.refuse(
        beyond_limit("NODES", "nodes", counts.nodes, options.limits.nodes, "/nodes"));
  }
  choose_scene(root, scenes, options, counts, document, check, file);
  take_buffers(buffers, document, check, file.member("buffers"));
  take_materials(materials, document, check, file.member("materials"));
  take_skins(skins, counts, document, check, file.member("skins"));
  thin_views(views, counts, document, check, file.member("bufferViews"));
  thin_accessors(accessors, counts, document, check, file.member("accessors"));
  thin_meshes(meshes, counts, document, check, file.member("meshes"));
  warn_of_names(document);
  thin_nodes(nodes, counts, document, check, file.member("nodes"));

  JsonChecker::keep_only(root, {"asset", "scenes", "nodes", "meshes", "accessors", "bufferViews"});
  if (json* asset = check.object(root, "asset", file)) JsonChecker::keep_only(*asset, {"version"});
}

}  // namespace sightline::gltf
