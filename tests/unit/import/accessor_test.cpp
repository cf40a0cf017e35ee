#include "core/import/gltf/accessor.h"

#include <gtest/gtest.h>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using gltf::Component;
using gltf::load_number;
using test::one_triangle;
using test::TinyFile;

template <class T>
double decoded(T value, Component component, bool normalized) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  return load_number(bytes, component, normalized);
}

TEST(LoadNumber, decodes_normalised_integers_by_the_formulas_of_gltf) {
  EXPECT_EQ(decoded<std::uint8_t>(255, Component::kU8, true), 1.0);
  EXPECT_EQ(decoded<std::uint8_t>(1, Component::kU8, true), 1.0 / 255);
  EXPECT_EQ(decoded<std::int8_t>(-128, Component::kI8, true), -1.0);
  EXPECT_EQ(decoded<std::int8_t>(-127, Component::kI8, true), -1.0);
  EXPECT_EQ(decoded<std::int8_t>(126, Component::kI8, true), 126.0 / 127);
  EXPECT_EQ(decoded<std::uint16_t>(65535, Component::kU16, true), 1.0);
  EXPECT_EQ(decoded<std::int16_t>(-32768, Component::kI16, true), -1.0);
  EXPECT_EQ(decoded<std::int16_t>(1, Component::kI16, true), 1.0 / 32767);
}

TEST(LoadNumber, takes_other_integers_and_floats_as_they_are) {
  EXPECT_EQ(decoded<std::int16_t>(-300, Component::kI16, false), -300.0);
  EXPECT_EQ(decoded<std::uint32_t>(4000000000u, Component::kU32, false), 4e9);
  EXPECT_EQ(decoded<float>(0.1f, Component::kF32, false), static_cast<double>(0.1f));
}

/// Spoils one number of the triangle's accessor or view and asks for the error.
std::string spoiled(const char* section, std::size_t index, const char* key,
                    const test::json& value) {
  TinyFile file = one_triangle();
  file.root[section][index][key] = value;
  return file.code();
}

TEST(Accessor, must_lie_inside_its_view) {
  EXPECT_EQ(spoiled("accessors", 0, "count", 4), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("accessors", 0, "byteOffset", 4), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("accessors", 0, "byteOffset", 9007199254740992u),
            "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("accessors", 0, "count", 9007199254740992u), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("bufferViews", 0, "byteLength", 35), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("bufferViews", 0, "byteStride", 16), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
}

TEST(Accessor, must_have_a_view_inside_its_buffer) {
  EXPECT_EQ(spoiled("bufferViews", 0, "byteLength", 1000), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("bufferViews", 0, "byteOffset", 1000), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  EXPECT_EQ(spoiled("bufferViews", 0, "byteOffset", 9007199254740992u),
            "GLTF_ACCESSOR_OUT_OF_BOUNDS");
}

TEST(Accessor, says_what_it_needs_and_what_there_is) {
  TinyFile file = one_triangle();
  file.root["accessors"][0]["count"] = 100;
  const auto scene = file.import();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message, "accessor 0: needs 1200 bytes, bufferView 0 has 36");
  EXPECT_EQ(scene.error().pointer, "/accessors/0");
}

TEST(Accessor, must_be_aligned_in_its_view) {
  for (const int view : {0, 1}) {
    TinyFile file = one_triangle();
    auto& bytes = file.root["bufferViews"][static_cast<std::size_t>(view)];
    bytes["byteLength"] = bytes["byteLength"].get<int>() + 1;
    if (view == 1) bytes["byteOffset"] = bytes["byteOffset"].get<int>() - 1;
    file.root["accessors"][static_cast<std::size_t>(view)]["byteOffset"] = 1;
    EXPECT_EQ(file.code(), "GLTF_ACCESSOR_INVALID") << view;
  }
}

TEST(Accessor, may_be_in_a_view_that_is_not_aligned) {
  TinyFile file = one_triangle();
  file.root["bufferViews"][0]["byteOffset"] = 2;
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0],
            "bufferView 0: starts at byte 2, which is not aligned to its components; read as it "
            "stands");
}

TEST(Accessor, may_end_exactly_where_its_view_ends_with_a_stride) {
  // Three positions 16 bytes apart need 2 * 16 + 12 bytes, not 3 * 16.
  TinyFile file = one_triangle();
  const int view = file.add_view<float>({0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0});
  file.root["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 16;
  file.root["accessors"][0]["bufferView"] = view;
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{0, 0, 0}, Vec3f{1, 0, 0}, Vec3f{0, 1, 0}}));
}

/// The triangle with a sparse part that moves vertex 1 to (5,6,7).
TinyFile sparse_triangle(bool with_base) {
  TinyFile file = one_triangle();
  const int indices = file.add_view<std::uint16_t>({1});
  const int values = file.add_view<float>({5, 6, 7});
  auto& accessor = file.root["accessors"][0];
  accessor["sparse"] = {{"count", 1},
                        {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                        {"values", {{"bufferView", values}}}};
  if (!with_base) accessor.erase("bufferView");
  return file;
}

TEST(SparseAccessor, replaces_elements_of_its_base) {
  const auto scene = sparse_triangle(true).import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{0, 0, 0}, Vec3f{5, 6, 7}, Vec3f{0, 1, 0}}));
}

TEST(SparseAccessor, replaces_zeros_when_there_is_no_base) {
  const auto scene = sparse_triangle(false).import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions, (SharedColumn<Vec3f>{Vec3f{}, Vec3f{5, 6, 7}, Vec3f{}}));
}

TEST(SparseAccessor, replaces_indices_too) {
  TinyFile file = one_triangle();
  const int at = file.add_view<std::uint8_t>({2});
  const int values = file.add_view<std::uint16_t>({1});
  file.root["accessors"][1]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", at}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", values}}}};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->indices, (IndexColumn{0, 1, 1}));
}

TEST(SparseAccessor, has_strictly_rising_indices_inside_the_accessor) {
  for (const auto& bad : {std::vector<std::uint16_t>{3}, {65535}, {1, 1}, {2, 1}}) {
    TinyFile file = sparse_triangle(true);
    const int indices = file.add_view<std::uint16_t>(bad);
    const int values = file.add_view<float>(std::vector<float>(bad.size() * 3));
    auto& sparse = file.root["accessors"][0]["sparse"];
    sparse["count"] = bad.size();
    sparse["indices"]["bufferView"] = indices;
    sparse["values"]["bufferView"] = values;
    EXPECT_EQ(file.code(), "GLTF_ACCESSOR_INVALID") << bad.size() << " from " << bad[0];
  }
}

TEST(SparseAccessor, must_have_all_its_bytes) {
  TinyFile file = sparse_triangle(true);
  file.root["accessors"][0]["sparse"]["values"]["byteOffset"] = 4;
  EXPECT_EQ(file.code(), "GLTF_ACCESSOR_OUT_OF_BOUNDS");
  file = sparse_triangle(true);
  file.root["accessors"][0]["sparse"]["indices"]["componentType"] = 65536 + 5123;
  EXPECT_EQ(file.code(), "GLTF_VALUE_INVALID");
}

TEST(AccessorWithoutBytes, is_all_zeros_up_to_a_limit) {
  TinyFile file = one_triangle();
  file.root["accessors"][0].erase("bufferView");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions, (SharedColumn<Vec3f>{{}, {}, {}}));
  ImportOptions options;
  options.limits.zero_filled = 2;
  EXPECT_EQ(file.code(options), "GLTF_LIMIT_ZERO_FILLED");
}

TEST(AccessorWithoutBytes, may_hold_the_indices) {
  TinyFile file = one_triangle();
  file.root["accessors"][1].erase("bufferView");
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->indices, (IndexColumn{0, 0, 0}));
}

}  // namespace
}  // namespace sightline
