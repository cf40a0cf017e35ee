#include "core/import/gltf/attribute_reader.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::TinyFile;

/// One triangle with colours of uint8, coordinates of uint16 and normals of float32.
TinyFile coloured_triangle() {
  TinyFile file = test::one_triangle();
  json& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  const json normalised = {{"normalized", true}};
  attributes["NORMAL"] = file.add<float>({1, 2, 3, 4, 5, 6, 7, 8, 9}, 5126, "VEC3", 3);
  attributes["TEXCOORD_0"] =
      file.add<std::uint16_t>({0, 65535, 13107, 0, 0, 0}, 5123, "VEC2", 3, normalised);
  attributes["COLOR_0"] = file.add<std::uint8_t>({255, 0, 51, 102, 0, 0, 0, 0, 0, 0, 0, 255}, 5121,
                                                 "VEC4", 3, normalised);
  return file;
}

enum class Source { kKept, kCopied, kGone };

/// What the import of the file finds; its bytes live as long as this.
struct Imported {
  Imported(const TinyFile& file, Source source)
      : bytes(std::make_shared<const std::vector<std::byte>>(file.bytes())), scene(Error{}) {
    ImportOptions options;
    if (source == Source::kKept) options.owner = bytes;
    options.copies_attributes = source != Source::kGone;
    scene = import_bytes(*bytes, options);
  }
  /// Of a vertex of the mesh's only primitive; nothing where it has no such attribute.
  std::optional<std::vector<double>> numbers(VertexAttribute attribute, std::uint64_t vertex) {
    const Mesh& mesh = *scene->meshes[0];
    if (mesh.attributes.empty() || mesh.attributes[0].of(attribute) == nullptr) return {};
    const VertexNumbers& found = *mesh.attributes[0].of(attribute);
    std::vector<double> out(found.components());
    if (!found.load(vertex, out.data(), touched)) return {};
    return out;
  }
  std::shared_ptr<const std::vector<std::byte>> bytes;
  Result<SceneDescription> scene;
  std::uint64_t touched = 0;
};

using Numbers = std::vector<double>;

TEST(AttributeReader, leaves_attributes_where_they_are_kept) {
  Imported kept(coloured_triangle(), Source::kKept);
  ASSERT_TRUE(kept.scene.ok()) << kept.scene.error().message;
  EXPECT_EQ(kept.scene->counts.touched.attributes, 0u);
  EXPECT_EQ(kept.scene->counts.skipped.attributes, 3u);
  EXPECT_EQ(kept.numbers(VertexAttribute::kNormal, 1), (Numbers{4, 5, 6}));
  EXPECT_EQ(kept.touched, 12u);
  EXPECT_EQ(kept.numbers(VertexAttribute::kUv, 0), (Numbers{0, 1}));
  EXPECT_EQ(kept.numbers(VertexAttribute::kUv, 1), (Numbers{0.2, 0}));
  EXPECT_EQ(kept.numbers(VertexAttribute::kColour, 0), (Numbers{1, 0, 0.2, 0.4}));
  EXPECT_EQ(kept.touched, 12u + 2 * 4 + 4);
}

TEST(AttributeReader, copies_what_would_be_gone_if_that_is_wanted) {
  Imported copied(coloured_triangle(), Source::kCopied);
  ASSERT_TRUE(copied.scene.ok()) << copied.scene.error().message;
  EXPECT_EQ(copied.scene->counts.touched.attributes, 36u + 12 + 12);
  copied.bytes.reset();
  EXPECT_EQ(copied.numbers(VertexAttribute::kNormal, 2), (Numbers{7, 8, 9}));
  EXPECT_EQ(copied.numbers(VertexAttribute::kColour, 2), (Numbers{0, 0, 0, 1}));
  EXPECT_EQ(copied.touched, 0u);
  Imported gone(coloured_triangle(), Source::kGone);
  ASSERT_TRUE(gone.scene.ok());
  EXPECT_TRUE(gone.scene->meshes[0]->attributes.empty());
  EXPECT_TRUE(gone.scene->warnings.empty());
}

TEST(AttributeReader, follows_sparse_and_absent_bytes) {
  TinyFile file = coloured_triangle();
  const int indices = file.add_view(std::vector<std::uint16_t>{1});
  const int values = file.add_view(std::vector<float>{-1, -2, -3});
  json& normals = file.root["accessors"][2];
  normals["sparse"] = {{"count", 1},
                       {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                       {"values", {{"bufferView", values}}}};
  for (const Source source : {Source::kKept, Source::kCopied}) {
    Imported with_base(file, source);
    ASSERT_TRUE(with_base.scene.ok()) << with_base.scene.error().message;
    EXPECT_EQ(with_base.numbers(VertexAttribute::kNormal, 0), (Numbers{1, 2, 3}));
    EXPECT_EQ(with_base.numbers(VertexAttribute::kNormal, 1), (Numbers{-1, -2, -3}));
    TinyFile bare = file;
    bare.root["accessors"][2].erase("bufferView");
    Imported without_base(bare, source);
    EXPECT_EQ(without_base.numbers(VertexAttribute::kNormal, 0), (Numbers{0, 0, 0}));
    EXPECT_EQ(without_base.numbers(VertexAttribute::kNormal, 1), (Numbers{-1, -2, -3}));
  }
}

TEST(AttributeReader, warns_of_what_it_leaves_out) {
  const auto warning_of = [](const json& change) {
    TinyFile file = coloured_triangle();
    file.root["accessors"][2].update(change);
    for (const Source source : {Source::kKept, Source::kCopied}) {
      Imported spoiled(file, source);
      if (!spoiled.scene) return spoiled.scene.error().message;
      EXPECT_FALSE(spoiled.numbers(VertexAttribute::kNormal, 0).has_value());
      EXPECT_TRUE(spoiled.numbers(VertexAttribute::kUv, 0).has_value());
      if (spoiled.scene->warnings.size() != 1) return std::string("not one warning");
      if (source == Source::kCopied) return spoiled.scene->warnings[0];
    }
    return std::string();
  };
  const std::string who = "mesh 0, primitive 0: NORMAL was left out: accessor 2";
  EXPECT_EQ(warning_of({{"count", 2}}), who + " has 2 elements, POSITION has 3");
  EXPECT_EQ(warning_of({{"count", 4}}), who + ": needs 48 bytes, bufferView 2 has 36");
  EXPECT_EQ(warning_of({{"type", "VEC2"}}), who + " is of another type than its attribute has");
  EXPECT_EQ(warning_of({{"componentType", 5121}}),
            who + " is of another type than its attribute has");
  EXPECT_EQ(warning_of({{"type", "MAT3"}}), who + ": a matrix is not expected here");
}

TEST(AttributeReader, opens_no_buffer_that_no_geometry_needs) {
  TinyFile file = coloured_triangle();
  const std::string normals =
      "data:application/octet-stream;base64,AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"
      "AAAAAAAAAAAAAIA/";
  file.root["buffers"] = {{{"byteLength", file.binary.size()}},
                          {{"byteLength", 36}, {"uri", normals}}};
  file.root["bufferViews"][2] = {{"buffer", 1}, {"byteLength", 36}};
  Imported apart(file, Source::kCopied);
  ASSERT_TRUE(apart.scene.ok()) << apart.scene.error().message;
  EXPECT_FALSE(apart.numbers(VertexAttribute::kNormal, 0).has_value());
  EXPECT_TRUE(apart.numbers(VertexAttribute::kUv, 0).has_value());
  ASSERT_EQ(apart.scene->warnings.size(), 1u);
  EXPECT_EQ(
      apart.scene->warnings[0],
      "mesh 0, primitive 0: NORMAL was left out: accessor 2 lies in a buffer that no geometry "
      "needs");
  // The same bytes, when a position stands beside them.
  file.root["bufferViews"][0] = {{"buffer", 1}, {"byteLength", 36}};
  Imported together(file, Source::kCopied);
  ASSERT_TRUE(together.scene.ok()) << together.scene.error().message;
  EXPECT_EQ(together.numbers(VertexAttribute::kNormal, 0), (Numbers{0, 0, 1}));
}

TEST(AttributeReader, leaves_out_what_an_invalid_target_moves) {
  TinyFile file = coloured_triangle();
  json& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["targets"] = {{{"POSITION", 0}}, {{"COLOR_0", 99}}};
  const auto found = [&](const json& weights) {
    file.root["meshes"][0]["weights"] = weights;
    Imported posed(file, Source::kKept);
    std::string names;
    for (const auto& [attribute, name] :
         {std::pair{VertexAttribute::kNormal, 'n'}, std::pair{VertexAttribute::kUv, 'u'},
          std::pair{VertexAttribute::kColour, 'c'}}) {
      if (posed.numbers(attribute, 0)) names += name;
    }
    return names;
  };
  EXPECT_EQ(found({0, 0}), "nuc");
  EXPECT_EQ(found({1, 0}), "nuc");
  EXPECT_EQ(found({0, 0.5}), "nu");
}

TEST(AttributeReader, finds_what_the_file_names) {
  TinyFile file = coloured_triangle();
  json& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["_T"] = file.add<std::uint32_t>({7, 70000, 4294967295}, 5125, "SCALAR", 3);
  attributes["_B"] =
      file.add<std::uint8_t>({0, 51, 255, 255, 0, 0}, 5121, "VEC2", 3, {{"normalized", true}});
  attributes["_b b"] = attributes["_T"];
  for (const Source source : {Source::kKept, Source::kCopied}) {
    Imported found(file, source);
    ASSERT_TRUE(found.scene.ok()) << found.scene.error().message;
    ASSERT_EQ(found.scene->named_attributes.size(), 2u);
    const auto known = [&](std::string_view name) {
      return find_named_attribute(*found.scene, name);
    };
    ASSERT_TRUE(known("_T") && known("_B"));
    EXPECT_FALSE(known("_b b") || known("_t") || known("NORMAL"));
    EXPECT_EQ(found.scene->named_attributes[named_index(*known("_B"))].components, 2u);
    EXPECT_TRUE(found.scene->named_attributes[named_index(*known("_T"))].is_in_scene);
    EXPECT_EQ(found.numbers(*known("_T"), 2), (Numbers{4294967295}));
    EXPECT_EQ(found.numbers(*known("_B"), 0), (Numbers{0, 0.2}));
    EXPECT_EQ(found.numbers(VertexAttribute::kNormal, 1), (Numbers{4, 5, 6}));
    ASSERT_EQ(found.scene->warnings.size(), 1u);
    EXPECT_TRUE(found.scene->warnings[0].starts_with(
        "1 attributes of primitives were left out, such as \"_b b\":"));
  }
}

TEST(AttributeReader, takes_the_type_of_a_name_from_its_first_primitive) {
  TinyFile file = test::one_triangle();
  json& primitives = file.root["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["attributes"]["_T"] = file.add<float>({1, 2, 3}, 5126, "SCALAR", 3);
  primitives[1]["attributes"]["_T"] = file.add<float>({1, 2, 3, 4, 5, 6}, 5126, "VEC2", 3);
  Imported found(file, Source::kCopied);
  ASSERT_TRUE(found.scene.ok()) << found.scene.error().message;
  EXPECT_EQ(found.scene->named_attributes[0].components, 1u);
  EXPECT_EQ(found.scene->meshes[0]->attributes.size(), 1u);
  ASSERT_EQ(found.scene->warnings.size(), 1u);
  EXPECT_EQ(found.scene->warnings[0],
            "mesh 0, primitive 1: _T was left out: accessor 3 is of another type than its "
            "attribute has");
}

TEST(AttributeReader, counts_vertices_as_the_file_does) {
  // Two primitives that share a range of vertices, neither of them from the first on.
  TinyFile file = test::one_triangle();
  std::vector<float> positions, coordinates;
  for (int i = 0; i < 10; ++i) {
    positions.insert(positions.end(), {static_cast<float>(i), static_cast<float>(i * i), 0});
    coordinates.insert(coordinates.end(), {static_cast<float>(i), 0});
  }
  const int position = file.add_positions(positions);
  const int coordinate = file.add(coordinates, 5126, "VEC2", 10);
  json& primitives = file.root["meshes"][0]["primitives"];
  primitives = json::array();
  for (const std::vector<std::uint16_t>& corners :
       {std::vector<std::uint16_t>{4, 9, 6}, std::vector<std::uint16_t>{7, 5, 8}}) {
    primitives.push_back({{"attributes", {{"POSITION", position}, {"TEXCOORD_0", coordinate}}},
                          {"indices", file.add(corners, 5123, "SCALAR", 3)}});
  }
  Imported imported(file, Source::kCopied);
  ASSERT_TRUE(imported.scene.ok()) << imported.scene.error().message;
  const Mesh& mesh = *imported.scene->meshes[0];
  ASSERT_EQ(mesh.attributes.size(), 2u);
  for (std::size_t corner = 0; corner < 6; ++corner) {
    const PrimitiveAttributes& attributes = mesh.attributes[corner / 3];
    const std::uint32_t vertex = mesh.indices[corner] + attributes.first_vertex;
    double uv[2];
    std::uint64_t touched = 0;
    ASSERT_TRUE(attributes.of(VertexAttribute::kUv)->load(vertex, uv, touched));
    EXPECT_EQ(uv[0], mesh.positions[mesh.indices[corner]].x);
  }
}

}  // namespace
}  // namespace sightline
