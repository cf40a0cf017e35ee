#include "core/import/gltf/mesh_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

/// Six vertices in a row, (i, i % 2, 0).
TinyFile row_of_six(int mode, const std::vector<std::uint8_t>& indices = {}) {
  TinyFile file = one_triangle();
  std::vector<float> xyz;
  for (int i = 0; i < 6; ++i) {
    for (int value : {i, i % 2, 0}) xyz.push_back(static_cast<float>(value));
  }
  json primitive = {{"attributes", {{"POSITION", file.add_positions(xyz)}}}, {"mode", mode}};
  if (!indices.empty()) {
    primitive["indices"] = file.add<std::uint8_t>(indices, 5121, "SCALAR", indices.size());
  }
  file.root["meshes"][0]["primitives"] = json::array({primitive});
  return file;
}

IndexColumn corners(const TinyFile& file) {
  const auto scene = file.import();
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  if (!scene || scene->meshes.empty()) return {};
  return scene->meshes[0]->indices;
}

TEST(Corners, of_plain_triangles_are_the_vertices_in_order) {
  EXPECT_EQ(corners(row_of_six(4)), (IndexColumn{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(corners(row_of_six(4, {0, 5, 1, 2, 3, 4})), (IndexColumn{0, 5, 1, 2, 3, 4}));
}

TEST(Corners, of_a_strip_turn_every_second_triangle) {
  EXPECT_EQ(corners(row_of_six(5, {0, 1, 2, 3, 4, 5})),
            (IndexColumn{0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4}));
  EXPECT_EQ(corners(row_of_six(5)), (IndexColumn{0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4}));
}

TEST(Corners, of_a_fan_end_at_the_first_vertex) {
  EXPECT_EQ(corners(row_of_six(6, {0, 2, 3, 4})), (IndexColumn{2, 3, 0, 3, 4, 0}));
}

TEST(Corners, that_make_no_whole_triangle_are_left_out_and_said) {
  for (int mode : {4, 5, 6}) {
    const auto scene = row_of_six(mode, {0, 1}).import();
    ASSERT_TRUE(scene.ok());
    EXPECT_TRUE(scene->meshes.empty());
    EXPECT_EQ(scene->warnings.size(), 1u);
  }
  const auto scene = row_of_six(4, {0, 1, 2, 3}).import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->meshes[0]->triangle_count(), 1u);
  EXPECT_EQ(scene->warnings.size(), 1u);
}

TEST(Corners, name_the_index_that_is_out_of_range) {
  const auto scene = row_of_six(5, {0, 1, 2, 3, 200}).import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, "GLTF_INDEX_OUT_OF_RANGE");
  EXPECT_EQ(scene.error().message, "mesh 0, primitive 0: index 4 is 200, there are 6 vertices");
}

TEST(Mesh, reads_only_the_range_of_vertices_that_its_triangles_use) {
  const TinyFile file = row_of_six(4, {3, 4, 5});
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  const Mesh& mesh = *scene->meshes[0];
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[0].x, 3);
  EXPECT_EQ(mesh.indices, (IndexColumn{0, 1, 2}));
}

/// A mesh of its own for each of these indices into the same six vertices, and a node for each.
TinyFile meshes_of_six(const std::vector<std::vector<std::uint8_t>>& meshes) {
  TinyFile file = row_of_six(4, meshes[0]);
  for (std::size_t i = 1; i < meshes.size(); ++i) {
    json mesh = file.root["meshes"][0];
    mesh["primitives"][0]["indices"] =
        file.add<std::uint8_t>(meshes[i], 5121, "SCALAR", meshes[i].size());
    file.root["meshes"].push_back(mesh);
    file.root["nodes"].push_back({{"mesh", i}});
    file.root["scenes"][0]["nodes"].push_back(i);
  }
  return file;
}

TEST(Mesh, is_read_among_others_as_it_is_alone) {
  const std::vector<std::vector<std::uint8_t>> meshes = {
      {0, 5, 1}, {3, 4, 5, 5, 4, 3}, {0, 1, 2, 3, 4, 5}, {2, 2, 2}};
  TinyFile file = meshes_of_six(meshes);
  // Of two primitives, and so read at once.
  file.root["meshes"][1]["primitives"].push_back(file.root["meshes"][3]["primitives"][0]);
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->meshes.size(), 4u);
  for (const std::size_t i : {0u, 2u, 3u}) {
    const auto alone = row_of_six(4, meshes[i]).import();
    EXPECT_EQ(scene->meshes[i]->file_mesh, i);
    EXPECT_EQ(scene->meshes[i]->indices, alone->meshes[0]->indices) << i;
    EXPECT_EQ(scene->meshes[i]->positions, alone->meshes[0]->positions) << i;
  }
  EXPECT_EQ(scene->meshes[1]->indices, (IndexColumn{0, 1, 2, 2, 1, 0, 3, 3, 3}));
  EXPECT_EQ(scene->counts.degenerate_triangles, 2u);
}

TEST(Mesh, that_is_wrong_is_named_before_those_that_come_after_it) {
  TinyFile file = meshes_of_six({{0, 1, 2}, {0, 1, 200}, {0, 1, 2}});
  EXPECT_EQ(file.code(), "GLTF_INDEX_OUT_OF_RANGE");
  // Found wrong earlier, but it comes later.
  json& last = file.root["meshes"][2]["primitives"][0];
  last["attributes"]["POSITION"] = last["indices"];
  const auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message.rfind("mesh 1, primitive 0: index 2 is 200", 0), 0u)
      << scene.error().message;
  file.root["meshes"][1]["primitives"][0].erase("indices");
  EXPECT_EQ(file.code(), "GLTF_ACCESSOR_INVALID");
}

TEST(Mesh, knows_whether_all_its_positions_are_used) {
  EXPECT_TRUE(row_of_six(4, {1, 2, 3}).import()->meshes[0]->all_used);
  EXPECT_FALSE(row_of_six(4, {1, 2, 4}).import()->meshes[0]->all_used);
  EXPECT_TRUE(row_of_six(5).import()->meshes[0]->all_used);
  TinyFile file = meshes_of_six({{0, 1, 2}, {4, 5, 5}});
  file.root["meshes"][0]["primitives"].push_back(file.root["meshes"][1]["primitives"][0]);
  EXPECT_TRUE(file.import()->meshes[0]->all_used) << "its primitives leave out the fourth";
}

TEST(Mesh, keeps_shared_vertices_of_its_primitives_once) {
  TinyFile file = row_of_six(4, {0, 4, 5});
  json second = file.root["meshes"][0]["primitives"][0];
  second["indices"] = file.add<std::uint8_t>({1, 2, 3}, 5121, "SCALAR", 3);
  file.root["meshes"][0]["primitives"].push_back(second);
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Mesh& mesh = *scene->meshes[0];
  EXPECT_EQ(mesh.positions.size(), 6u);
  EXPECT_EQ(mesh.indices, (IndexColumn{0, 4, 5, 1, 2, 3}));
  ASSERT_EQ(mesh.primitives.size(), 2u);
  EXPECT_EQ(mesh.primitives[1].first_triangle, 1u);
  EXPECT_EQ(mesh.primitives[1].file_primitive, 1u);
}

TEST(Mesh, appends_the_vertices_of_its_primitives) {
  TinyFile file = one_triangle();
  const int other = file.add_positions({5, 5, 5, 6, 5, 5, 5, 6, 5});
  json second = file.root["meshes"][0]["primitives"][0];
  second["attributes"]["POSITION"] = other;
  file.root["meshes"][0]["primitives"].push_back(second);
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->meshes[0]->indices, (IndexColumn{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(scene->meshes[0]->positions[3].x, 5);
}

TEST(Mesh, knows_its_materials) {
  TinyFile file = one_triangle();
  file.root["materials"] = {{{"name", "brick"}, {"doubleSided", true}}, json::object()};
  file.root["meshes"][0]["primitives"][0]["material"] = 0;
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->materials.size(), 2u);
  EXPECT_EQ(scene->materials[0].name, "brick");
  EXPECT_TRUE(scene->materials[0].double_sided);
  EXPECT_FALSE(scene->materials[1].double_sided);
  EXPECT_EQ(scene->meshes[0]->primitives[0].material, 0u);
}

TEST(Mesh, counts_triangles_that_are_not_finite) {
  TinyFile file = one_triangle();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  file.root["accessors"][0]["bufferView"] = file.add_view<float>({0, 0, 0, nan, 0, 0, 0, 1, 0});
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->counts.nonfinite_triangles, 1u);
  EXPECT_EQ(scene->warnings.size(), 1u);
}

TEST(QuantizedMesh, is_decoded_in_float64_and_rounded_once) {
  TinyFile file = one_triangle();
  const int view = file.add_view<std::int16_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, -32768, 0, 0});
  file.root["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 8;
  auto& accessor = file.root["accessors"][0];
  accessor["bufferView"] = view;
  accessor["componentType"] = 5122;
  accessor["normalized"] = true;
  EXPECT_EQ(file.code(), "GLTF_ACCESSOR_INVALID") << "the extension is not named";
  file.root["extensionsUsed"] = {"KHR_mesh_quantization"};
  file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions[1].x, static_cast<float>(1.0 / 32767));
  EXPECT_EQ(scene->meshes[0]->positions[2].y, -1);
  accessor["normalized"] = false;
  EXPECT_EQ(file.import()->meshes[0]->positions[2].y, -32768);
}

/// The triangle with two morph targets: +x by 1, and vertex 1 by (0,8,0) through a sparse accessor.
TinyFile morphed_triangle() {
  TinyFile file = one_triangle();
  const int first = file.add_positions({1, 0, 0, 1, 0, 0, 1, 0, 0});
  const int second = file.add_positions({0, 0, 0, 0, 0, 0, 0, 0, 0});
  auto& sparse = file.root["accessors"][static_cast<std::size_t>(second)];
  sparse.erase("bufferView");
  const int indices = file.add_view<std::uint16_t>({1});
  const int values = file.add_view<float>({0, 8, 0});
  sparse["sparse"] = {{"count", 1},
                      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                      {"values", {{"bufferView", values}}}};
  file.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", first}},
                                                        {{"POSITION", second}}};
  return file;
}

TEST(MorphedMesh, stands_as_its_default_weights_say) {
  TinyFile file = morphed_triangle();
  file.root["meshes"][0]["weights"] = {0.5, 0.25};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{0.5f, 0, 0}, Vec3f{1.5f, 2, 0}, Vec3f{0.5f, 1, 0}}));
}

TEST(MorphedMesh, without_weights_stands_unmorphed) {
  const auto scene = morphed_triangle().import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->meshes[0]->positions[1], (Vec3f{1, 0, 0}));
}

TEST(MorphedMesh, takes_the_weights_of_its_node_first_and_is_stored_once_per_pose) {
  TinyFile file = morphed_triangle();
  file.root["meshes"][0]["weights"] = {0.5, 0};
  file.root["nodes"] = {{{"mesh", 0}},
                        {{"mesh", 0}, {"weights", {0, 1}}},
                        {{"mesh", 0}},
                        {{"mesh", 0}, {"weights", {0.5, 0}}}};
  file.root["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes.size(), 2u);
  ASSERT_EQ(scene->instances.size(), 4u);
  EXPECT_EQ(scene->instances[0].mesh, scene->instances[2].mesh);
  EXPECT_EQ(scene->instances[0].mesh, scene->instances[3].mesh);
  EXPECT_EQ(scene->meshes[scene->instances[1].mesh]->positions[1], (Vec3f{1, 8, 0}));
}

TEST(MorphedMesh, refuses_a_target_of_another_length) {
  TinyFile file = morphed_triangle();
  file.root["meshes"][0]["weights"] = {1};
  file.root["accessors"][2]["count"] = 2;
  EXPECT_EQ(file.code(), "GLTF_ACCESSOR_INVALID");
  file.root["meshes"][0]["weights"] = {0};
  EXPECT_EQ(file.code(), "") << "a target with weight zero is not read";
}

TEST(MeshLimits, hold_for_triangles_and_bytes) {
  ImportOptions options;
  options.limits.triangles = 1;
  EXPECT_EQ(row_of_six(4, {0, 1, 2}).code(options), "");
  EXPECT_EQ(row_of_six(4).code(options), "GLTF_LIMIT_TRIANGLES");
  options = {};
  options.limits.geometry_bytes = 100;
  EXPECT_EQ(row_of_six(4).code(options), "GLTF_LIMIT_GEOMETRY_BYTES");
}

TEST(ImportLimits, name_the_place_and_both_numbers) {
  const TinyFile row = row_of_six(4);
  TinyFile deep = test::one_triangle();
  deep.root["nodes"] = {{{"children", {1}}}, {{"mesh", 0}}};
  TinyFile zeros = test::one_triangle();
  zeros.root["accessors"][0].erase("bufferView");
  struct Case {
    const TinyFile& file;
    void (*lower)(ImportLimits&);
    const char* code;
    const char* message;
    const char* pointer;
  };
  const auto size = std::to_string(row.bytes().size());
  const std::string too_large = "bytes of the file: " + size + ", the limit is 99";
  const Case cases[] = {
      {row, [](ImportLimits& l) { l.file_bytes = 99; }, "FILE_BYTES", too_large.c_str(), ""},
      {row, [](ImportLimits& l) { l.triangles = 1; }, "TRIANGLES",
       "mesh 0, primitive 0: triangles so far: 2, the limit is 1", ""},
      {deep, [](ImportLimits& l) { l.nodes = 1; }, "NODES", "nodes: 2, the limit is 1", "/nodes"},
      {deep, [](ImportLimits& l) { l.node_depth = 1; }, "NODE_DEPTH",
       "node 1: depth below its root: 2, the limit is 1", "/nodes/1"},
      {row, [](ImportLimits& l) { l.instances = 0; }, "INSTANCES",
       "node 0: instances so far: 1, the limit is 0", ""},
      {row, [](ImportLimits& l) { l.geometry_bytes = 71; }, "GEOMETRY_BYTES",
       "bytes of positions, indices and instances in memory: 96, the limit is 71", ""},
      {zeros, [](ImportLimits& l) { l.zero_filled = 2; }, "ZERO_FILLED",
       "accessor 0: elements without bytes in the file: 3, the limit is 2", "/accessors/0"},
  };
  for (const Case& c : cases) {
    ImportOptions options;
    c.lower(options.limits);
    const auto scene = c.file.import(options);
    ASSERT_FALSE(scene.ok()) << c.code;
    EXPECT_EQ(scene.error().kind, ErrorKind::kTooLarge);
    EXPECT_EQ(scene.error().code, std::string("GLTF_LIMIT_") + c.code);
    EXPECT_EQ(scene.error().message, c.message);
    EXPECT_EQ(scene.error().pointer, c.pointer);
  }
}

TEST(MeshLimits, stop_many_accessors_that_show_the_same_bytes) {
  // A thousand primitives over one view: small in the file, large in memory.
  TinyFile file = row_of_six(5);
  json primitive = file.root["meshes"][0]["primitives"][0];
  const json accessor = file.root["accessors"].back();
  for (int i = 0; i < 1000; ++i) {
    file.root["accessors"].push_back(accessor);
    primitive["attributes"]["POSITION"] = file.root["accessors"].size() - 1;
    file.root["meshes"][0]["primitives"].push_back(primitive);
  }
  ImportOptions options;
  options.limits.geometry_bytes = 10000;
  EXPECT_EQ(file.code(options), "GLTF_LIMIT_GEOMETRY_BYTES");
}

/// Six vertices in a row, of which triangles use those from `first` on.
TinyFile indexed_row(std::uint32_t first) {
  TinyFile file = row_of_six(4);
  json& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["indices"] = file.add<std::uint32_t>(
      {first, first + 1, first + 2, first + 2, first + 1, first + 3}, 5125, "SCALAR", 6);
  return file;
}

bool lies_in(std::span<const std::byte> bytes, const void* at) {
  return at >= bytes.data() && at < bytes.data() + bytes.size();
}

TEST(Sharing, looks_at_positions_and_indices_where_kept_bytes_have_them) {
  for (const std::uint32_t first : {0u, 2u}) {
    const TinyFile file = indexed_row(first);
    const auto copied = file.import();
    const auto bytes = std::make_shared<const std::vector<std::byte>>(file.bytes());
    ImportOptions options;
    options.owner = bytes;
    const auto shared = import_bytes(*bytes, options);
    ASSERT_TRUE(copied.ok() && shared.ok());
    const Mesh &mesh = *shared->meshes[0], &copy = *copied->meshes[0];
    EXPECT_EQ(mesh.positions, copy.positions);
    EXPECT_EQ(mesh.indices, copy.indices);
    EXPECT_TRUE(lies_in(*bytes, mesh.positions.data()));
    // Vertices that nothing uses are left out, and then the indices are others than the file's.
    EXPECT_EQ(lies_in(*bytes, mesh.indices.listed().data()), first == 0);
    EXPECT_FALSE(lies_in(*bytes, copy.positions.data()));
    EXPECT_EQ(shared->counts.touched.positions, copied->counts.touched.positions);
    EXPECT_GT(bytes.use_count(), 2);
  }
}

TEST(Corners, are_not_listed_where_they_are_the_vertices_in_their_order) {
  std::vector<TinyFile> files{row_of_six(4), row_of_six(4, {0, 1, 2, 3, 4, 5}),
                              row_of_six(5, {3, 4, 5}), row_of_six(4)};
  files[3].root["meshes"][0]["primitives"][0]["indices"] =
      files[3].add<std::uint32_t>({1, 2, 3}, 5125, "SCALAR", 3);
  for (const TinyFile& file : files) {
    const auto bytes = std::make_shared<const std::vector<std::byte>>(file.bytes());
    for (const bool is_kept : {false, true}) {
      ImportOptions options;
      if (is_kept) options.owner = bytes;
      const auto scene = import_bytes(*bytes, options);
      ASSERT_TRUE(scene.ok());
      const Mesh& mesh = *scene->meshes[0];
      EXPECT_TRUE(mesh.indices.listed().empty());
      EXPECT_EQ(mesh.indices, IndexColumn::sequence(mesh.positions.size()));
    }
  }
  EXPECT_EQ(corners(row_of_six(4, {0, 1, 2, 3, 5, 4})).listed().size(), 6u);
}

TEST(Sharing, copies_what_has_to_be_changed) {
  TinyFile strip = row_of_six(5, {0, 1, 2, 3, 4, 5});
  TinyFile two = indexed_row(0);
  json& primitives = two.root["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  for (const TinyFile* file : {&strip, &two}) {
    const auto bytes = std::make_shared<const std::vector<std::byte>>(file->bytes());
    ImportOptions options;
    options.owner = bytes;
    const auto shared = import_bytes(*bytes, options);
    const auto copied = file->import();
    ASSERT_TRUE(shared.ok() && copied.ok());
    EXPECT_EQ(shared->meshes[0]->indices, copied->meshes[0]->indices);
    EXPECT_EQ(shared->meshes[0]->positions, copied->meshes[0]->positions);
    EXPECT_FALSE(lies_in(*bytes, shared->meshes[0]->indices.listed().data()));
  }
}

TEST(Corners, without_bytes_are_zeros_however_many) {
  TinyFile file = row_of_six(4);
  file.root["accessors"].push_back(
      {{"componentType", 5125}, {"count", 300000}, {"type", "SCALAR"}});
  file.root["meshes"][0]["primitives"][0]["indices"] = file.root["accessors"].size() - 1;
  const auto indices = corners(file);
  EXPECT_EQ(indices.size(), 300000u);
  EXPECT_EQ(std::count(indices.begin(), indices.end(), 0u), 300000);
}

TEST(Sharing, refuses_an_index_out_of_range_as_a_copy_does) {
  TinyFile file = indexed_row(3);
  const auto bytes = std::make_shared<const std::vector<std::byte>>(file.bytes());
  ImportOptions options;
  options.owner = bytes;
  const auto shared = import_bytes(*bytes, options);
  const auto copied = file.import();
  ASSERT_FALSE(shared.ok());
  ASSERT_FALSE(copied.ok());
  EXPECT_EQ(shared.error().code, "GLTF_INDEX_OUT_OF_RANGE");
  EXPECT_EQ(shared.error().message, copied.error().message);
}

}  // namespace
}  // namespace sightline
