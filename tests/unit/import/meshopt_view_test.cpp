#include "core/import/codec/meshopt_view.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <numeric>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using gltf::MeshoptMode;
using gltf::MeshoptView;
using test::json;
using test::one_triangle;
using test::TinyFile;

constexpr const char* kExtensionName = "EXT_meshopt_compression";

std::vector<std::uint8_t> encode_elements(const void* data, std::size_t count, std::size_t stride) {
  std::vector<std::uint8_t> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  return out;
}

std::vector<std::uint8_t> encode_triangles(const std::vector<std::uint32_t>& indices) {
  std::vector<std::uint8_t> out(meshopt_encodeIndexBufferBound(indices.size(), 1000));
  out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
  return out;
}

/// Makes view `view` of the file a compressed one that only this extension can fill.
json& compress(TinyFile& file, std::size_t view, const std::vector<std::uint8_t>& bytes,
               std::size_t count, std::size_t stride, const char* mode) {
  const auto packed = static_cast<std::size_t>(file.add_view(bytes));
  const json source = file.root["bufferViews"][packed];
  file.root["bufferViews"].erase(packed);
  file.root["bufferViews"][view] = {{"buffer", 1},
                                    {"byteLength", count * stride},
                                    {"extensions",
                                     {{kExtensionName,
                                       {{"buffer", 0},
                                        {"byteOffset", source["byteOffset"]},
                                        {"byteLength", source["byteLength"]},
                                        {"byteStride", stride},
                                        {"count", count},
                                        {"mode", mode}}}}}};
  file.root["extensionsUsed"] = {kExtensionName};
  file.root["extensionsRequired"] = {kExtensionName};
  file.root["buffers"] = {
      {{"byteLength", file.binary.size()}},
      {{"byteLength", 1000}, {"extensions", {{kExtensionName, {{"fallback", true}}}}}}};
  return file.root["bufferViews"][view]["extensions"][kExtensionName];
}

const std::vector<float> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

TinyFile compressed_positions() {
  TinyFile file = one_triangle();
  compress(file, 0, encode_elements(kTriangle.data(), 3, 12), 3, 12, "ATTRIBUTES");
  return file;
}

TEST(MeshoptView, gives_positions_as_they_were) {
  const auto scene = compressed_positions().import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}}));
}

TEST(MeshoptView, gives_indices_of_both_kinds_and_widths) {
  std::vector<std::uint32_t> indices = {0, 1, 2, 2, 1, 0, 1, 2, 0};
  std::vector<std::uint8_t> sequence(meshopt_encodeIndexSequenceBound(indices.size(), 3));
  sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(),
                                              indices.size()));
  for (const std::size_t stride : {2u, 4u}) {
    for (const char* mode : {"TRIANGLES", "INDICES"}) {
      TinyFile file = one_triangle();
      const bool triangles = mode[0] == 'T';
      compress(file, 1, triangles ? encode_triangles(indices) : sequence, indices.size(), stride,
               mode);
      file.root["accessors"][1]["count"] = indices.size();
      file.root["accessors"][1]["componentType"] = stride == 2 ? 5123 : 5125;
      const auto scene = file.import();
      ASSERT_TRUE(scene.ok()) << mode << stride << scene.error().message;
      const auto& got = scene->meshes[0]->indices;
      ASSERT_EQ(got.size(), indices.size());
      // The codec of triangles may turn one, never flip it.
      for (std::size_t i = 0; i < got.size(); i += 3) {
        std::size_t turn = 0;
        while (turn < 3 && got[i + turn] != indices[i]) ++turn;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(got[i + (k + turn) % 3], indices[i + k]);
        EXPECT_TRUE(triangles || turn == 0);
      }
    }
  }
}

TEST(MeshoptView, applies_the_exponential_filter) {
  // Mantissa in the low 24 bits, exponent in the high 8: 3 * 2^-2, -5 * 2^1, 0.
  const std::vector<std::uint32_t> raw = {0xfe000003u, 0x01fffffbu, 0, 0, 0, 0, 0, 0, 0};
  TinyFile file = one_triangle();
  compress(file, 0, encode_elements(raw.data(), 3, 12), 3, 12, "ATTRIBUTES")["filter"] =
      "EXPONENTIAL";
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions[0], (Vec3f{0.75f, -10, 0}));
}

TEST(MeshoptView, applies_the_quaternion_filter_to_the_rotations_of_instances) {
  // The largest component is left out; its number stands in the low bits of the fourth. 2 says
  // that it is z, and zeros for the others make it 1: half a turn about z.
  const std::vector<std::int16_t> raw = {0, 0, 0, 4 * 4094 + 2};
  TinyFile file = one_triangle();
  const int rotation =
      file.add<std::int16_t>({0, 0, 0, 0}, 5122, "VEC4", 1, {{"normalized", true}});
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] =
      rotation;
  compress(file, 2, encode_elements(raw.data(), 1, 8), 1, 8, "ATTRIBUTES")["filter"] = "QUATERNION";
  file.root["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Affine& m = scene->instances[0].world_from_mesh;
  EXPECT_EQ(m.m[0][0], -1);
  EXPECT_EQ(m.m[1][1], -1);
  EXPECT_EQ(m.m[2][2], 1);
}

/// The triangle with normals (0,0,1) (0,1,0) (1,0,0) in a view of their own.
TinyFile compressed_normals() {
  const std::vector<float> normals = {0, 0, 1, 0, 1, 0, 1, 0, 0};
  TinyFile file = one_triangle();
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = file.add_positions(normals);
  compress(file, 2, encode_elements(normals.data(), 3, 12), 3, 12, "ATTRIBUTES");
  return file;
}

TEST(MeshoptView, of_normals_is_decoded_when_a_hit_asks) {
  const TinyFile file = compressed_normals();
  const std::uint64_t packed =
      file.root["bufferViews"][2]["extensions"][kExtensionName]["byteLength"];
  const auto bytes = std::make_shared<const std::vector<std::byte>>(file.bytes());
  for (const bool is_kept : {true, false}) {
    ImportOptions options;
    if (is_kept) options.owner = bytes;
    options.copies_attributes = true;
    const auto scene = import_bytes(*bytes, options);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene->counts.touched.compressed, 0u);
    ASSERT_EQ(scene->meshes[0]->attributes.size(), 1u);
    const VertexNumbers& normals = *scene->meshes[0]->attributes[0].of(VertexAttribute::kNormal);
    EXPECT_EQ(normals.bytes(), is_kept ? 0 : packed);
    double n[3];
    std::uint64_t touched = 0;
    for (std::uint64_t vertex = 0; vertex < 3; ++vertex) {
      ASSERT_TRUE(normals.load(vertex, n, touched));
      for (std::uint64_t k = 0; k < 3; ++k) EXPECT_EQ(n[k], k + vertex == 2 ? 1 : 0);
    }
    EXPECT_EQ(touched, is_kept ? packed : 0);
  }
}

TEST(MeshoptView, of_normals_that_is_damaged_says_nothing) {
  TinyFile file = compressed_normals();
  const std::size_t at = file.root["bufferViews"][2]["extensions"][kExtensionName]["byteOffset"];
  file.binary[at] = std::byte{0x55};
  ImportOptions options;
  options.copies_attributes = true;
  const auto scene = file.import(options);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  double n[3];
  std::uint64_t touched = 0;
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(scene->meshes[0]->attributes[0].of(VertexAttribute::kNormal)->load(0, n, touched));
  }
}

TEST(MeshoptView, is_decoded_once_for_all_its_accessors) {
  TinyFile file = compressed_positions();
  file.root["accessors"].push_back(file.root["accessors"][0]);
  json second = file.root["meshes"][0]["primitives"][0];
  second["attributes"]["POSITION"] = file.root["accessors"].size() - 1;
  file.root["meshes"][0]["primitives"].push_back(second);
  ImportOptions options;
  // Decoded: 36. Then twice three positions and three indices.
  options.limits.geometry_bytes = 36 + 2 * (36 + 12) + sizeof(Instance);
  EXPECT_EQ(file.code(options), "");
  options.limits.geometry_bytes -= 1;
  EXPECT_EQ(file.code(options), "GLTF_LIMIT_GEOMETRY_BYTES");
}

TEST(MeshoptView, counts_its_compressed_bytes_as_touched) {
  const TinyFile file = compressed_positions();
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  const std::uint64_t packed =
      file.root["bufferViews"][0]["extensions"][kExtensionName]["byteLength"];
  const auto plain = one_triangle().import();
  const auto json_bytes = [](const TinyFile& f) {
    const auto bytes = f.bytes();
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    return length;
  };
  EXPECT_EQ(scene->counts.bytes_touched, json_bytes(file) + packed + 6);
  EXPECT_EQ(plain->counts.bytes_touched, json_bytes(one_triangle()) + 36 + 6);
}

TEST(MeshoptView, refuses_what_breaks_a_rule_of_the_extension) {
  const auto spoiled = [](const char* key, const json& value) {
    TinyFile file = compressed_positions();
    json& view = file.root["bufferViews"][0];
    view["extensions"][kExtensionName][key] = value;
    const auto stride = view["extensions"][kExtensionName]["byteStride"];
    const auto count = view["extensions"][kExtensionName]["count"];
    if (stride.is_number_unsigned() && count.is_number_unsigned()) {
      view["byteLength"] = stride.get<std::uint64_t>() * count.get<std::uint64_t>();
    }
    return file.code();
  };
  EXPECT_EQ(spoiled("byteStride", 0u), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("byteStride", 13u), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("byteStride", 260u), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("byteStride", "12"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("count", 0u), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("mode", "TRIANGLES"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("mode", "POINTS"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("mode", 1), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("filter", "OCTAHEDRAL"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("filter", "QUATERNION"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("filter", "COLOR"), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("byteLength", 0u), "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled("buffer", 7), "GLTF_REFERENCE_INVALID");
  EXPECT_EQ(spoiled("byteOffset", 100000u), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("byteOffset", 1u << 31), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
}

TEST(MeshoptView, must_decode_to_the_length_and_stride_of_its_view) {
  TinyFile file = compressed_positions();
  file.root["bufferViews"][0]["byteLength"] = 40;
  EXPECT_EQ(file.code(), "GLTF_VALUE_INVALID");
  file = compressed_positions();
  file.root["bufferViews"][0]["byteStride"] = 16;
  EXPECT_EQ(file.code(), "GLTF_VALUE_INVALID");
  file.root["bufferViews"][0]["byteStride"] = 12;
  EXPECT_EQ(file.code(), "");
}

TEST(MeshoptView, refuses_a_count_that_its_bytes_cannot_hold_before_memory_is_taken) {
  TinyFile file = compressed_positions();
  json& view = file.root["bufferViews"][0];
  const std::uint64_t count = 600'000'000;
  view["extensions"][kExtensionName]["count"] = count;
  view["byteLength"] = count * 12;
  file.root["accessors"][0]["count"] = count;
  const auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, "GLTF_COMPRESSION_INVALID");
  EXPECT_EQ(scene.error().pointer, "/bufferViews/0/extensions/EXT_meshopt_compression");
  EXPECT_EQ(scene.error().message.rfind("bufferView 0: EXT_meshopt_compression: 600000000 elements "
                                        "of 12 bytes need at least 112500033 compressed bytes",
                                        0),
            0u)
      << scene.error().message;
}

TEST(MeshoptView, states_a_least_size_that_the_smallest_encodings_keep) {
  for (const std::size_t stride : {4u, 12u, 32u, 64u, 256u}) {
    for (const std::size_t count : {1u, 15u, 16u, 17u, 63u, 64u, 65u, 255u, 256u, 257u, 5000u}) {
      const std::vector<std::uint8_t> zeros(count * stride);
      MeshoptView view;
      view.count = count;
      view.stride = stride;
      EXPECT_GE(encode_elements(zeros.data(), count, stride).size(), fewest_bytes(view))
          << count << " of " << stride;
    }
  }
}

TEST(MeshoptView, answers_every_damage_with_an_error_or_numbers) {
  std::vector<std::uint32_t> indices(std::size_t{3} * 200);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    indices[i] = static_cast<std::uint32_t>(i / 3 + (i * 7) % 5);
  }
  std::vector<float> floats(std::size_t{3} * 210);
  for (std::size_t i = 0; i < floats.size(); ++i) floats[i] = static_cast<float>(i * i % 97);
  const auto packed_indices = encode_triangles(indices);
  const auto packed_floats = encode_elements(floats.data(), 210, 12);
  MeshoptView triangles, elements;
  triangles.count = 600, triangles.stride = 4, triangles.mode = MeshoptMode::kTriangles;
  elements.count = 210, elements.stride = 12;
  for (const auto& [view, good] :
       {std::pair{triangles, packed_indices}, std::pair{elements, packed_floats}}) {
    std::size_t refused = 0;
    for (std::size_t i = 0; i < good.size(); ++i) {
      for (const unsigned flip : {1u, 0x80u, 0xffu}) {
        auto bad = good;
        bad[i] = static_cast<std::uint8_t>(bad[i] ^ flip);
        const auto out = decode_meshopt(view, std::as_bytes(std::span(bad)), "here", "");
        if (!out) {
          EXPECT_EQ(out.error().code, "GLTF_COMPRESSION_INVALID");
          ++refused;
        }
      }
      const auto cut = std::as_bytes(std::span(good)).first(i);
      EXPECT_FALSE(decode_meshopt(view, cut, "here", "").ok()) << i << " bytes";
    }
    EXPECT_GT(refused, 0u);
  }
}

}  // namespace
}  // namespace sightline
