#include "core/import/codec/draco_mesh.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using gltf::Budget;
using gltf::decode_draco;
using gltf::DracoClaim;
using test::json;
using test::one_triangle;
using test::TinyFile;

constexpr const char* kName = "KHR_draco_mesh_compression";

struct Encoded {
  std::vector<std::uint8_t> bytes;
  std::uint64_t triangles = 0, points = 0;

  std::span<const std::byte> span() const { return std::as_bytes(std::span(bytes)); }
  DracoClaim claim() const { return {triangles, points, {0}}; }
};

struct Options {
  int method = draco::MESH_EDGEBREAKER_ENCODING;
  int speed = 5;
  int bits = 0;                          ///< of quantised positions; 0: float32 as they are
  bool has_texture_coordinates = false;  ///< attribute 1, of 10 bits
  int more_attributes = 0;               ///< of one uint8 each
};

/// A grid of n * n squares, z = height(x, y).
template <class Height>
Encoded encode_grid(int n, const Height& height, const Options& options) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * n * n);
  const int positions =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  std::vector<int> others;
  others.reserve(static_cast<std::size_t>(options.more_attributes));
  for (int i = 0; i < options.more_attributes; ++i) {
    others.push_back(builder.AddAttribute(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT8));
  }
  const auto point = [&](int x, int y) {
    return std::array<float, 3>{static_cast<float>(x), static_cast<float>(y), height(x, y)};
  };
  const int coordinates =
      options.has_texture_coordinates
          ? builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32)
          : -1;
  auto add_face = [&, face = 0u](const auto& p, const auto& q, const auto& r) mutable {
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(face), &p, &q, &r);
    if (coordinates >= 0) {
      builder.SetAttributeValuesForFace(coordinates, draco::FaceIndex(face), &p, &q, &r);
    }
    for (const int other : others) {
      builder.SetAttributeValuesForFace(other, draco::FaceIndex(face), "1", "1", "1");
    }
    ++face;
  };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto a = point(x, y), b = point(x + 1, y), c = point(x + 1, y + 1), d = point(x, y + 1);
      add_face(a, b, c);
      add_face(a, c, d);
    }
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(options.method);
  encoder.SetSpeedOptions(options.speed, options.speed);
  if (options.bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, options.bits);
  }
  if (coordinates >= 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 10);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {{buffer.data(), buffer.data() + buffer.size()}, mesh->num_faces(), mesh->num_points()};
}

float wavy(int x, int y) { return static_cast<float>((x * 7 + y * 5) % 11) / 4; }
float flat(int, int) { return 0; }

/// A file whose only primitive is the mesh; accessor 0 is POSITION, 1 the indices.
TinyFile compressed_file(const Encoded& mesh) {
  TinyFile file = one_triangle();
  const int view = file.add_view(mesh.bytes);
  auto& accessors = file.root["accessors"];
  accessors[0].erase("bufferView");
  accessors[0]["count"] = mesh.points;
  accessors[1].erase("bufferView");
  accessors[1]["count"] = mesh.triangles * 3;
  file.root["meshes"][0]["primitives"][0]["extensions"][kName] = {
      {"bufferView", view}, {"attributes", {{"POSITION", 0}}}};
  file.root["extensionsUsed"] = {kName};
  file.root["extensionsRequired"] = {kName};
  return file;
}

TEST(DracoMesh, gives_the_triangles_that_were_compressed_by_either_method) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    for (const int speed : {0, 5, 10}) {
      const auto scene = compressed_file(encode_grid(5, wavy, {method, speed, 0})).import();
      ASSERT_TRUE(scene.ok()) << scene.error().message;
      const Mesh& mesh = *scene->meshes[0];
      ASSERT_EQ(mesh.triangle_count(), 50u);
      std::vector<int> seen(50, 0);
      for (std::uint32_t i = 0; i < 50; ++i) {
        Vec3f sum = {0, 0, 0};
        const auto corner = [&](std::size_t k) {
          return mesh.positions[mesh.indices[std::size_t{3} * i + k]];
        };
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3f p = corner(k);
          EXPECT_EQ(p.z, wavy(static_cast<int>(p.x), static_cast<int>(p.y)));
          sum.x += p.x, sum.y += p.y;
        }
        // The winding stays: counter-clockwise seen from +z.
        EXPECT_GT((corner(1).x - corner(0).x) * (corner(2).y - corner(0).y) -
                      (corner(2).x - corner(0).x) * (corner(1).y - corner(0).y),
                  0);
        const auto x = static_cast<std::size_t>(sum.x / 3), y = static_cast<std::size_t>(sum.y / 3);
        const bool lower = sum.x / 3 - static_cast<float>(x) > sum.y / 3 - static_cast<float>(y);
        ++seen[2 * (5 * y + x) + (lower ? 0 : 1)];
      }
      EXPECT_EQ(seen, std::vector<int>(50, 1));
    }
  }
}

TEST(DracoMesh, moves_quantised_positions_by_half_a_step_at_most) {
  const auto scene = compressed_file(encode_grid(5, wavy, {1, 5, 12})).import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const double step = 5.0 / ((1 << 12) - 1);
  for (const Vec3f& p : scene->meshes[0]->positions) {
    EXPECT_NEAR(static_cast<double>(p.x), std::round(static_cast<double>(p.x)), 0.51 * step);
    EXPECT_NEAR(static_cast<double>(p.y), std::round(static_cast<double>(p.y)), 0.51 * step);
  }
}

/// The grid with attribute 1 of its Draco bytes as `name`, accessor 2.
TinyFile with_attribute(const Encoded& grid, const char* name, int component, const char* type) {
  TinyFile file = compressed_file(grid);
  file.root["accessors"].push_back(
      {{"componentType", component}, {"type", type}, {"count", grid.points}});
  json& primitive = file.root["meshes"][0]["primitives"][0];
  primitive["attributes"][name] = 2;
  primitive["extensions"][kName]["attributes"][name] = 1;
  return file;
}

TinyFile with_coordinates(const Encoded& grid) {
  return with_attribute(grid, "TEXCOORD_0", 5126, "VEC2");
}

TEST(DracoMesh, has_its_coordinates_decoded_when_a_hit_asks) {
  Options options;
  options.has_texture_coordinates = true;
  const TinyFile file = with_coordinates(encode_grid(5, wavy, options));
  const auto bytes = std::make_shared<const std::vector<std::byte>>(file.bytes());
  const std::uint64_t packed = file.root["bufferViews"].back()["byteLength"];
  for (const bool is_kept : {true, false}) {
    ImportOptions import_options;
    if (is_kept) import_options.owner = bytes;
    import_options.copies_attributes = true;
    const auto scene = import_bytes(*bytes, import_options);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const Mesh& mesh = *scene->meshes[0];
    ASSERT_EQ(mesh.attributes.size(), 1u);
    const VertexNumbers& coordinates = *mesh.attributes[0].of(VertexAttribute::kUv);
    EXPECT_EQ(coordinates.bytes(), is_kept ? 0 : packed);
    std::uint64_t touched = 0;
    for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
      double uv[2];
      ASSERT_TRUE(coordinates.load(i + mesh.attributes[0].first_vertex, uv, touched));
      EXPECT_NEAR(uv[0], static_cast<double>(mesh.positions[i].x), 5.0 / 1023);
      EXPECT_NEAR(uv[1], static_cast<double>(mesh.positions[i].y), 5.0 / 1023);
    }
    EXPECT_EQ(touched, is_kept ? packed : 0);
  }
}

TEST(DracoMesh, holds_attributes_that_the_file_names) {
  Options options;
  options.more_attributes = 1;
  const auto bytes = with_attribute(encode_grid(5, wavy, options), "_A", 5121, "SCALAR").bytes();
  ImportOptions import_options;
  import_options.copies_attributes = true;
  const auto scene = import_bytes(bytes, import_options);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->meshes[0]->attributes.size(), 1u);
  const PrimitiveAttributes& attributes = scene->meshes[0]->attributes[0];
  double number = 0;
  std::uint64_t touched = 0;
  ASSERT_TRUE(attributes.of(*find_named_attribute(*scene, "_A"))
                  ->load(attributes.first_vertex, &number, touched));
  EXPECT_EQ(number, '1');
}

TEST(DracoMesh, says_nothing_of_coordinates_that_it_does_not_hold) {
  ImportOptions import_options;
  import_options.copies_attributes = true;
  // There is no attribute 1 in the bytes; then another type is stated than is there.
  for (const bool is_there : {false, true}) {
    Options options;
    options.has_texture_coordinates = is_there;
    TinyFile file = with_coordinates(encode_grid(5, wavy, options));
    if (is_there) file.root["accessors"][2].update({{"componentType", 5121}, {"normalized", true}});
    const auto scene = file.import(import_options);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    double uv[2];
    std::uint64_t touched = 0;
    const auto& attributes = scene->meshes[0]->attributes;
    ASSERT_EQ(attributes.size(), 1u);
    EXPECT_FALSE(attributes[0].of(VertexAttribute::kUv)->load(0, uv, touched));
  }
}

TEST(DracoMesh, is_left_alone_when_the_file_has_plain_bytes_and_does_not_require_it) {
  TinyFile file = one_triangle();
  file.root["meshes"][0]["primitives"][0]["extensions"][kName] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  file.root["extensionsUsed"] = {kName};
  EXPECT_EQ(file.code(), "");
  file.root["extensionsRequired"] = {kName};
  EXPECT_EQ(file.code(), "GLTF_COMPRESSION_INVALID");
}

TEST(DracoMesh, must_hold_as_many_triangles_and_points_as_its_accessors_state) {
  const Encoded grid = encode_grid(5, wavy, {});
  TinyFile file = compressed_file(grid);
  file.root["accessors"][1]["count"] = 147;
  auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, "GLTF_COMPRESSION_INVALID");
  EXPECT_EQ(scene.error().message,
            "mesh 0, primitive 0: KHR_draco_mesh_compression: its bytes hold 50 triangles, the "
            "accessors 49");
  EXPECT_EQ(scene.error().pointer, "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression");
  file = compressed_file(grid);
  file.root["accessors"][0]["count"] = 37;
  scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("hold 36 points, the accessors 37"), std::string::npos)
      << scene.error().message;
}

TEST(DracoMesh, refuses_what_breaks_a_rule_of_the_extension) {
  const Encoded grid = encode_grid(2, flat, {});
  const auto spoiled = [&](const auto& spoil) {
    TinyFile file = compressed_file(grid);
    json& primitive = file.root["meshes"][0]["primitives"][0];
    spoil(file.root, primitive, primitive["extensions"][kName]);
    return file.code();
  };
  EXPECT_EQ(spoiled([](json&, json&, json&) {}), "");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco.erase("bufferView"); }),
            "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco["bufferView"] = 9; }),
            "GLTF_REFERENCE_INVALID");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco["attributes"] = 1; }),
            "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco["attributes"]["POSITION"] = -1; }),
            "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco["attributes"]["POSITION"] = 5; }),
            "GLTF_COMPRESSION_INVALID");
  EXPECT_EQ(spoiled([](json&, json&, json& draco) { draco["attributes"].erase("POSITION"); }),
            "GLTF_COMPRESSION_INVALID");
  EXPECT_EQ(spoiled([](json&, json& primitive, json&) { primitive.erase("indices"); }),
            "GLTF_COMPRESSION_INVALID");
  EXPECT_EQ(spoiled([](json&, json& primitive, json&) { primitive["mode"] = 5; }),
            "GLTF_EXTENSION_UNSUPPORTED");
  EXPECT_EQ(spoiled([](json& root, json&, json&) {
              root["accessors"][0]["componentType"] = 5122;
              root["extensionsUsed"].push_back("KHR_mesh_quantization");
            }),
            "GLTF_ACCESSOR_INVALID");
}

TEST(DracoMesh, takes_no_memory_for_triangles_that_its_bytes_cannot_hold) {
  // The header of an edgebreaker mesh with 2^30 triangles, and nothing after it.
  const std::vector<std::uint8_t> header = {
      'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0, 0x10, 0x80, 0x80, 0x80, 0x80, 0x04, 0x00, 0x10};
  const ImportLimits limits;
  Budget budget(limits);
  const auto mesh =
      decode_draco(std::as_bytes(std::span(header)), {1u << 30, 16, {0}}, budget, "here", "");
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.error().message,
            "here: KHR_draco_mesh_compression: 20 compressed bytes cannot hold 1073741824 "
            "triangles");
}

TEST(DracoMesh, spends_what_decoding_needs_and_returns_it) {
  const Encoded grid = encode_grid(20, wavy, {});
  ImportLimits limits;
  limits.geometry_bytes = 100000;
  Budget small(limits);
  const auto refused = decode_draco(grid.span(), grid.claim(), small, "here", "");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, "GLTF_LIMIT_GEOMETRY_BYTES");
  EXPECT_TRUE(small.spend_bytes(100000).ok()) << "what was spent came back";
  limits.geometry_bytes = 1000000;
  Budget enough(limits);
  EXPECT_TRUE(decode_draco(grid.span(), grid.claim(), enough, "here", "").ok());
  EXPECT_TRUE(enough.spend_bytes(1000000).ok());
}

TEST(DracoMesh, reads_the_most_regular_mesh_there_is) {
  const Encoded grid = encode_grid(255, flat, {1, 0, 8});
  const ImportLimits limits;
  Budget budget(limits);
  EXPECT_TRUE(decode_draco(grid.span(), grid.claim(), budget, "here", "").ok());
  RecordProperty("triangles_per_byte", static_cast<int>(grid.triangles / grid.bytes.size()));
}

TEST(DracoMesh, refuses_more_attributes_than_any_primitive_has) {
  const ImportLimits limits;
  Budget budget(limits);
  const Encoded many = encode_grid(2, flat, {1, 5, 11, false, 63});
  EXPECT_TRUE(decode_draco(many.span(), many.claim(), budget, "here", "").ok());
  const Encoded more = encode_grid(2, flat, {1, 5, 11, false, 64});
  const auto refused = decode_draco(more.span(), more.claim(), budget, "here", "");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message,
            "here: KHR_draco_mesh_compression: its bytes hold 65 attributes, the limit is 64");
}

TEST(DracoMesh, refuses_more_orientations_than_there_are_texture_coordinates) {
  // A bit for each texture coordinate says on which side of an edge it lies. Their number is stated
  // on its own, and entropy coding makes 2^31 of them from no bytes.
  const Encoded good = encode_grid(6, wavy, {1, 0, 11, true});
  DracoClaim claim = good.claim();
  claim.attributes = {0, 1};
  const ImportLimits limits;
  Budget budget(limits);
  ASSERT_TRUE(decode_draco(good.span(), claim, budget, "here", "").ok());
  std::size_t refused = 0;
  for (std::size_t at = 0; at + 4 <= good.bytes.size(); ++at) {
    // Where four bytes are a small number, it may be theirs.
    if (good.bytes[at] == 0 || good.bytes[at + 1] + good.bytes[at + 2] + good.bytes[at + 3] != 0) {
      continue;
    }
    Encoded bad = good;
    for (const std::size_t i : {0u, 1u, 2u}) bad.bytes[at + i] = 0xff;
    bad.bytes[at + 3] = 0x7f;
    const auto mesh = decode_draco(bad.span(), claim, budget, "here", "");
    if (mesh.ok()) continue;
    refused += mesh.error().message ==
               "here: KHR_draco_mesh_compression: its bytes hold 2147483647 orientations of " +
                   std::to_string(good.points) + " texture coordinates";
  }
  EXPECT_EQ(refused, 1u);
}

TEST(DracoMesh, answers_every_damage_with_an_error_or_a_mesh_in_range) {
  for (const Options& options :
       {Options{0, 5, 0}, Options{0, 0, 11}, Options{1, 10, 11}, Options{1, 0, 11}}) {
    const Encoded good = encode_grid(6, wavy, options);
    std::size_t refused = 0;
    for (std::size_t i = 0; i < good.bytes.size(); ++i) {
      for (const unsigned flip : {1u, 2u, 0x40u, 0x80u, 0xffu}) {
        Encoded bad = good;
        bad.bytes[i] = static_cast<std::uint8_t>(bad.bytes[i] ^ flip);
        const ImportLimits limits;
        Budget budget(limits);
        const auto mesh = decode_draco(bad.span(), bad.claim(), budget, "here", "");
        if (!mesh) {
          ++refused;
          continue;
        }
        ASSERT_EQ(mesh->corners.size(), good.triangles * 3);
        for (const std::uint32_t corner : mesh->corners) ASSERT_LT(corner, good.points);
        const gltf::DecodedElements& positions = mesh->attributes.at(0);
        ASSERT_EQ(positions.bytes.size(),
                  good.points * component_bytes(positions.component) * positions.components);
      }
      const ImportLimits limits;
      Budget budget(limits);
      static_cast<void>(decode_draco(good.span().first(i), good.claim(), budget, "here", ""));
    }
    EXPECT_GT(refused, 0u);
  }
}

}  // namespace
}  // namespace sightline
