#include "core/import/gltf/gltf_model.h"

#include <array>
#include <string_view>
#include <utility>

#include "core/import/gltf/gltf_document.h"

namespace sightline::gltf {

using nlohmann::json;

namespace {

/// Sets `value` where the member is there.
template <class T>
void take(json& object, const char* key, T& value) {
  const auto found = object.find(key);
  if (found == object.end()) return;
  if constexpr (std::is_same_v<T, std::string>) {
    value = std::move(found->get_ref<std::string&>());
  } else {
    value = found->get<T>();
  }
}

/// Calls `read` for each element of a list, with a new element of `to`.
template <class T, class Read>
void take_each(json& object, const char* key, std::vector<T>& to, const Read& read) {
  const auto list = object.find(key);
  if (list == object.end()) return;
  to.reserve(list->size());
  for (json& element : *list) read(element, to.emplace_back());
}

void read_scene(json& object, tinygltf::Scene& scene) {
  take(object, "name", scene.name);
  take(object, "nodes", scene.nodes);
}

/// EXT_mesh_gpu_instancing, the only extension that is left.
void read_extensions(const json& extensions, tinygltf::Node& node) {
  for (const auto& [name, extension] : extensions.items()) {
    tinygltf::Value::Object attributes;
    for (const auto& [attribute, accessor] : extension["attributes"].items()) {
      attributes.emplace(attribute, tinygltf::Value(accessor.get<int>()));
    }
    tinygltf::Value::Object value;
    value.emplace("attributes", tinygltf::Value(std::move(attributes)));
    node.extensions.emplace(name, tinygltf::Value(std::move(value)));
  }
}

void read_node(json& object, tinygltf::Node& node) {
  take(object, "name", node.name);
  take(object, "children", node.children);
  take(object, "mesh", node.mesh);
  take(object, "skin", node.skin);
  take(object, "matrix", node.matrix);
  take(object, "translation", node.translation);
  take(object, "rotation", node.rotation);
  take(object, "scale", node.scale);
  take(object, "weights", node.weights);
  if (const auto found = object.find("extensions"); found != object.end()) {
    read_extensions(*found, node);
  }
}

void read_primitive(json& object, tinygltf::Primitive& primitive) {
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  take(object, "attributes", primitive.attributes);
  take(object, "indices", primitive.indices);
  take(object, "mode", primitive.mode);
  take(object, "material", primitive.material);
  take(object, "targets", primitive.targets);
}

void read_mesh(json& object, tinygltf::Mesh& mesh) {
  take(object, "name", mesh.name);
  take(object, "weights", mesh.weights);
  take_each(object, "primitives", mesh.primitives, read_primitive);
}

int type_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, int>, 7> kTypes{
      {{"SCALAR", TINYGLTF_TYPE_SCALAR},
       {"VEC2", TINYGLTF_TYPE_VEC2},
       {"VEC3", TINYGLTF_TYPE_VEC3},
       {"VEC4", TINYGLTF_TYPE_VEC4},
       {"MAT2", TINYGLTF_TYPE_MAT2},
       {"MAT3", TINYGLTF_TYPE_MAT3},
       {"MAT4", TINYGLTF_TYPE_MAT4}}};
  for (const auto& [text, type] : kTypes) {
    if (text == name) return type;
  }
  return -1;
}

void read_accessor(json& object, tinygltf::Accessor& accessor) {
  take(object, "bufferView", accessor.bufferView);
  take(object, "byteOffset", accessor.byteOffset);
  take(object, "normalized", accessor.normalized);
  take(object, "componentType", accessor.componentType);
  take(object, "count", accessor.count);
  accessor.type = type_of(object["type"].get_ref<const std::string&>());
  accessor.sparse = {};  // it has no constructor
  const auto found = object.find("sparse");
  if (found == object.end()) return;
  accessor.sparse.isSparse = true;
  auto& sparse = accessor.sparse;
  json &indices = (*found)["indices"], &values = (*found)["values"];
  take(*found, "count", sparse.count);
  take(indices, "bufferView", sparse.indices.bufferView);
  take(indices, "byteOffset", sparse.indices.byteOffset);
  take(indices, "componentType", sparse.indices.componentType);
  take(values, "bufferView", sparse.values.bufferView);
  take(values, "byteOffset", sparse.values.byteOffset);
}

void read_view(json& object, tinygltf::BufferView& view) {
  take(object, "buffer", view.buffer);
  take(object, "byteOffset", view.byteOffset);
  take(object, "byteLength", view.byteLength);
  take(object, "byteStride", view.byteStride);
}

}  // namespace

tinygltf::Model read_model(json& root) {
  tinygltf::Model model;
  take_each(root, "scenes", model.scenes, read_scene);
  take_each(root, "nodes", model.nodes, read_node);
  take_each(root, "meshes", model.meshes, read_mesh);
  take_each(root, "accessors", model.accessors, read_accessor);
  take_each(root, "bufferViews", model.bufferViews, read_view);
  return model;
}

}  // namespace sightline::gltf
