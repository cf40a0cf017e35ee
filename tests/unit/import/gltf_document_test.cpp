#include "core/import/gltf/gltf_document.h"

#include <gtest/gtest.h>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

/// The code of the error after one member of the good file was replaced.
std::string spoiled(const char* pointer, const json& value) {
  TinyFile file = one_triangle();
  file.root[json::json_pointer(pointer)] = value;
  return file.code();
}

TEST(GltfDocument, refuses_members_of_the_wrong_type) {
  for (const auto& [pointer, value] : std::vector<std::pair<const char*, json>>{
           {"/asset", 1},
           {"/asset/version", 2},
           {"/scenes", json::object()},
           {"/scenes/0", 1},
           {"/scenes/0/name", 1},
           {"/scenes/0/nodes", 1},
           {"/scenes/0/nodes/0", "0"},
           {"/nodes", json::object()},
           {"/nodes/0", nullptr},
           {"/nodes/0/name", 5},
           {"/nodes/0/mesh", "0"},
           {"/nodes/0/mesh", 0.5},
           {"/nodes/0/mesh", true},
           {"/nodes/0/skin", -1},
           {"/nodes/0/children", 1},
           {"/nodes/0/weights", 1},
           {"/nodes/0/weights", {"a"}},
           {"/nodes/0/scale", {1, 1}},
           {"/nodes/0/translation", {1, 1, nullptr}},
           {"/nodes/0/rotation", "x"},
           {"/nodes/0/extensions", 1},
           {"/nodes/0/extensions", {{"EXT_mesh_gpu_instancing", 1}}},
           {"/nodes/0/extensions", {{"EXT_mesh_gpu_instancing", json::object()}}},
           {"/meshes/0", json::array()},
           {"/meshes/0/primitives", json::object()},
           {"/meshes/0/primitives/0", 1},
           {"/meshes/0/primitives/0/mode", 7},
           {"/meshes/0/primitives/0/attributes", json::array()},
           {"/meshes/0/primitives/0/targets", 1},
           {"/meshes/0/primitives/0/targets", {1}},
           {"/accessors/0/type", 3},
           {"/accessors/0/type", "vec3"},
           {"/accessors/0/count", 0},
           {"/accessors/0/count", 1e300},
           {"/accessors/0/count", 9007199254740993u},
           {"/accessors/0/componentType", 5124},
           {"/accessors/0/normalized", 1},
           {"/accessors/0/min", 1},
           {"/accessors/0/sparse", 1},
           {"/accessors/0/sparse", json::object()},
           {"/bufferViews/0/byteLength", 0},
           {"/bufferViews/0/byteOffset", -1},
           {"/bufferViews/0/byteStride", 6},
           {"/bufferViews/0/byteStride", 256},
           {"/buffers", {{{"byteLength", 44}, {"uri", 3}}}},
           {"/buffers", {{{"byteLength", 0}}}},
           {"/materials", {1}},
           {"/materials", {{{"name", 1}}}},
           {"/materials", {{{"doubleSided", 1}}}},
           {"/skins", 1},
           {"/extensionsRequired", "KHR_mesh_quantization"},
           {"/extensionsUsed", {1}}}) {
    EXPECT_EQ(spoiled(pointer, value), "GLTF_VALUE_INVALID") << pointer << " = " << value;
  }
}

TEST(GltfDocument, refuses_references_to_what_is_not_there) {
  for (const auto& [pointer, value] : std::vector<std::pair<const char*, json>>{
           {"/scene", 1},
           {"/scenes/0/nodes/0", 1},
           {"/nodes/0/mesh", 4294967296u},
           {"/nodes/0/children", {1}},
           {"/meshes/0/primitives/0/indices", 2},
           {"/meshes/0/primitives/0/attributes/POSITION", 2},
           {"/meshes/0/primitives/0/targets", {{{"POSITION", 2}}}},
           {"/accessors/0/bufferView", 2},
           {"/bufferViews/0/buffer", 1}}) {
    EXPECT_EQ(spoiled(pointer, value), "GLTF_REFERENCE_INVALID") << pointer << " = " << value;
  }
}

TEST(GltfDocument, says_where_and_gives_both_numbers) {
  TinyFile file = one_triangle();
  file.root["meshes"][0]["primitives"][0]["indices"] = 7;
  const auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message,
            "meshes[0].primitives[0].indices is 7, the file has 2 accessors");
  EXPECT_EQ(scene.error().pointer, "/meshes/0/primitives/0/indices");
}

TEST(GltfDocument, takes_integers_written_with_a_point) {
  TinyFile file = one_triangle();
  file.root["accessors"][0]["count"] = 3.0;
  file.root["nodes"][0]["mesh"] = 0.0;
  EXPECT_EQ(file.code(), "");
}

TEST(GltfDocument, knows_version_two_only) {
  EXPECT_EQ(spoiled("/asset/version", "1.0"), "GLTF_VERSION_UNSUPPORTED");
  EXPECT_EQ(spoiled("/asset/version", "20"), "GLTF_VERSION_UNSUPPORTED");
  EXPECT_EQ(spoiled("/asset/version", "2.1"), "");
  EXPECT_EQ(spoiled("/asset/minVersion", "2.1"), "GLTF_VERSION_UNSUPPORTED");
  EXPECT_EQ(spoiled("/asset/minVersion", "2.0"), "");
}

TEST(GltfDocument, refuses_unknown_required_extensions_by_name) {
  TinyFile file = one_triangle();
  file.root["extensionsUsed"] = {"FOO_bar"};
  EXPECT_EQ(file.code(), "");
  file.root["extensionsRequired"] = {"KHR_materials_unlit", "FOO_bar"};
  const auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().kind, ErrorKind::kUnsupported);
  EXPECT_EQ(scene.error().code, "GLTF_EXTENSION_UNSUPPORTED");
  EXPECT_NE(scene.error().message.find("FOO_bar"), std::string::npos);
  EXPECT_EQ(scene.error().pointer, "/extensionsRequired/1");
}

TEST(GltfDocument, never_looks_at_what_rays_do_not_need) {
  TinyFile file = one_triangle();
  file.root["images"] = {{{"uri", "/dev/zero"}}, 17};
  file.root["textures"] = "nonsense";
  file.root["animations"] = {{{"channels", 3}}};
  file.root["cameras"] = 5;
  file.root["extras"] = {{"anything", {1, 2, 3}}};
  file.root["nodes"][0]["camera"] = 99;
  file.root["nodes"][0]["extras"] = "x";
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 99;
  EXPECT_EQ(file.code(), "");
}

TEST(GltfDocument, survives_the_loss_of_any_member) {
  // Every object and array element of a good file taken out once: an answer, never a crash.
  const json good = one_triangle().root;
  const json flat = good.flatten();
  for (const auto& [path, value] : flat.items()) {
    json::json_pointer pointer(path);
    while (!pointer.empty()) {
      TinyFile file = one_triangle();
      json& parent = file.root[pointer.parent_pointer()];
      if (parent.is_array()) {
        parent.erase(std::stoul(pointer.back()));
      } else {
        parent.erase(pointer.back());
      }
      const auto scene = file.import();
      if (!scene) {
        EXPECT_NE(scene.error().code, "GLTF_INTERNAL") << pointer;
      }
      pointer.pop_back();
    }
  }
}

}  // namespace
}  // namespace sightline
