#include "core/import/gltf/skinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/data_folder.h"
#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline {
namespace {

using test::json;
using test::one_triangle;
using test::TinyFile;

/// The triangle in node 0, far away; its vertices follow joint 0, joint 1 and half of each. Joint 0
/// (node 1) stands at x = 10, joint 1 (node 2) is its child, 1 higher in y.
TinyFile skinned_triangle() {
  TinyFile file = one_triangle();
  file.root["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {777, 0, 0}}},
                        {{"translation", {10, 0, 0}}, {"children", {2}}},
                        {{"translation", {0, 1, 0}}}};
  file.root["scenes"][0]["nodes"] = {0, 1};
  const int joints = file.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 5121, "VEC4", 3);
  const int weights = file.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, 5126, "VEC4", 3);
  auto& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = joints;
  attributes["WEIGHTS_0"] = weights;
  file.root["skins"] = {{{"joints", {1, 2}}}};
  return file;
}

SharedColumn<Vec3f> positions(const TinyFile& file) {
  const auto scene = file.import();
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return scene ? scene->meshes[0]->positions : SharedColumn<Vec3f>();
}

TEST(SkinnedMesh, follows_its_joints_and_not_its_node) {
  const auto scene = skinned_triangle().import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{10, 0, 0}, Vec3f{11, 1, 0}, Vec3f{10, 1.5f, 0}}));
  EXPECT_TRUE(scene->instances[0].world_from_mesh.is_identity());
  EXPECT_TRUE(scene->warnings.empty()) << scene->warnings[0];
}

TEST(SkinnedMesh, is_moved_by_inverse_bind_matrices_first) {
  TinyFile file = skinned_triangle();
  // Joint 0: twice as large. Joint 1: minus (1,0,0).
  file.root["skins"][0]["inverseBindMatrices"] =
      file.add<float>({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0,  0, 0, 1,  //
                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1},
                      5126, "MAT4", 2);
  EXPECT_EQ(positions(file),
            (SharedColumn<Vec3f>{Vec3f{10, 0, 0}, Vec3f{10, 1, 0}, Vec3f{9.5f, 2, 0}}));
}

TEST(SkinnedMesh, says_that_a_last_row_of_a_bind_matrix_was_left_out) {
  TinyFile file = skinned_triangle();
  file.root["skins"][0]["inverseBindMatrices"] =
      file.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5f,  //
                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                      5126, "MAT4", 2);
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->meshes[0]->positions[0], (Vec3f{10, 0, 0}));
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0],
            "skin 0: the last row of inverse bind matrix 0 is not 0 0 0 1 and was taken as if it "
            "were");
}

TEST(SkinnedMesh, is_morphed_before_it_is_posed_and_rounded_once) {
  TinyFile file = skinned_triangle();
  const int deltas = file.add_positions({0x1p-24f, 0, 0, 0, 0, 3, 0, 0, 0});
  file.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", deltas}}};
  file.root["meshes"][0]["weights"] = {1};
  file.root["nodes"][1]["translation"] = {-1, 0, 0};
  // 1 + 2^-24 would round to 1, and 1 - 1 to 0.
  file.root["accessors"][0]["bufferView"] = file.add_view<float>({1, 0, 0, 1, 0, 0, 0, 1, 0});
  EXPECT_EQ(positions(file),
            (SharedColumn<Vec3f>{Vec3f{0x1p-24f, 0, 0}, Vec3f{0, 1, 3}, Vec3f{-1, 1.5f, 0}}));
}

TEST(SkinnedMesh, takes_normalised_weights_and_more_than_four_joints) {
  TinyFile file = skinned_triangle();
  const int joints = file.add<std::uint16_t>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5123, "VEC4", 3);
  const int weights = file.add<std::uint8_t>({51, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC4", 3,
                                             {{"normalized", true}});
  const int first = file.add<std::uint8_t>({204, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0}, 5121, "VEC4",
                                           3, {{"normalized", true}});
  auto& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["WEIGHTS_0"] = first;
  attributes["JOINTS_1"] = joints;
  attributes["WEIGHTS_1"] = weights;
  const auto got = positions(file);
  const double a = 204.0 / 255, b = 51.0 / 255;
  EXPECT_EQ(got[0], (Vec3f{static_cast<float>(a * 10 + b * 10), static_cast<float>(b * 1), 0}));
  EXPECT_EQ(got[2], (Vec3f{10, 2, 0}));
}

TEST(SkinnedMesh, uses_weights_as_they_stand_and_says_when_they_do_not_sum_to_one) {
  TinyFile file = skinned_triangle();
  file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
      file.add<float>({2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC4", 3);
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->meshes[0]->positions,
            (SharedColumn<Vec3f>{Vec3f{20, 0, 0}, Vec3f{11, 1, 0}, Vec3f{0, 0, 0}}));
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0],
            "mesh 0, primitive 0: the skin's weights of 2 vertices do not sum to 1 and were used "
            "as they stand");
}

TEST(SkinnedMesh, is_stored_once_for_each_skin_and_once_without) {
  TinyFile file = skinned_triangle();
  file.root["skins"].push_back({{"joints", {2, 1}}});
  for (const int skin : {1, 0}) file.root["nodes"].push_back({{"mesh", 0}, {"skin", skin}});
  file.root["nodes"].push_back({{"mesh", 0}});
  file.root["scenes"][0]["nodes"] = {0, 1, 3, 4, 5};
  const auto scene = file.import();
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->instances.size(), 4u);
  EXPECT_EQ(scene->meshes.size(), 3u);
  EXPECT_EQ(scene->instances[0].mesh, scene->instances[2].mesh);
  EXPECT_EQ(scene->meshes[scene->instances[3].mesh]->positions[1], (Vec3f{1, 0, 0}));
}

TEST(SkinnedMesh, is_refused_when_it_cannot_be_posed) {
  const auto spoiled = [](const auto& spoil) {
    TinyFile file = skinned_triangle();
    spoil(file);
    return file.code();
  };
  const auto attributes = [](TinyFile& file) -> json& {
    return file.root["meshes"][0]["primitives"][0]["attributes"];
  };
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file).erase("JOINTS_0"); }),
            "GLTF_SKIN_INVALID");
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file).erase("WEIGHTS_0"); }),
            "GLTF_SKIN_INVALID");
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file)["JOINTS_1"] = 2; }),
            "GLTF_SKIN_INVALID");
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file)["JOINTS_0"] = 0; }),
            "GLTF_ACCESSOR_INVALID");
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file)["WEIGHTS_0"] = 2; }),
            "GLTF_ACCESSOR_INVALID");
  EXPECT_EQ(spoiled([&](TinyFile& file) { attributes(file)["WEIGHTS_0"] = 99; }),
            "GLTF_REFERENCE_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) { file.root["accessors"][2]["count"] = 2; }),
            "GLTF_ACCESSOR_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) { file.root["skins"][0]["joints"] = {1}; }),
            "GLTF_INDEX_OUT_OF_RANGE");
  EXPECT_EQ(spoiled([](TinyFile& file) {
              file.root["skins"][0]["joints"] = {1, 9};
            }),
            "GLTF_REFERENCE_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) { file.root["skins"][0]["joints"] = json::array(); }),
            "GLTF_VALUE_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) { file.root["scenes"][0]["nodes"] = {0}; }),
            "GLTF_SKIN_INVALID")
      << "the joints are not in the scene";
  EXPECT_EQ(spoiled([](TinyFile& file) { file.root["skins"][0]["inverseBindMatrices"] = 0; }),
            "GLTF_SKIN_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) {
              const float nan = std::numeric_limits<float>::quiet_NaN();
              file.root["skins"][0]["inverseBindMatrices"] =
                  file.add<float>(std::vector<float>(32, nan), 5126, "MAT4", 2);
            }),
            "GLTF_TRANSFORM_INVALID");
  EXPECT_EQ(spoiled([](TinyFile& file) {
              file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
                       ["TRANSLATION"] = 0;
            }),
            "GLTF_INSTANCING_INVALID");
}

TEST(SkinnedMesh, never_looks_at_joints_of_a_mesh_that_no_skin_poses) {
  TinyFile file = skinned_triangle();
  file.root["nodes"][0].erase("skin");
  file.root["skins"] = json::array();
  file.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 99;
  EXPECT_EQ(file.code(), "");
}

// knight_skinned.glb a second time: 4 x 4 matrices in long double, blended before they are applied.

using Matrix = std::array<std::array<long double, 4>, 4>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix r = {};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) r[i][j] += a[i][k] * b[k][j];
    }
  }
  return r;
}

class RawGlb {
 public:
  explicit RawGlb(const std::vector<std::byte>& file) {
    std::uint32_t length = 0;
    std::memcpy(&length, file.data() + 12, 4);
    const char* text = reinterpret_cast<const char*>(file.data()) + 20;
    root = json::parse(text, text + length);
    binary_ = file.data() + 20 + length + 8;
  }

  /// Number `c` of element `i`.
  long double number(const json& index, std::size_t i, std::size_t c) const {
    const json& accessor = root["accessors"][index.get<std::size_t>()];
    const json& view = root["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::string type = accessor["type"];
    const std::size_t n = type == "MAT4" ? 16 : type == "VEC4" ? 4 : 3;
    const int component = accessor["componentType"];
    const std::size_t size = component == 5126 ? 4 : component == 5121 ? 1 : 2;
    const std::byte* at = binary_ + view.value("byteOffset", 0) + accessor.value("byteOffset", 0) +
                          i * view.value("byteStride", n * size) + c * size;
    if (size == 1) return std::to_integer<int>(*at);
    if (size == 2) return std::to_integer<int>(at[0]) + 256 * std::to_integer<int>(at[1]);
    float value = 0;
    std::memcpy(&value, at, 4);
    return static_cast<long double>(value);
  }

  Matrix world(std::size_t node) const {
    const json& source = root["nodes"][node];
    const auto numbers = [&](const char* key, const std::vector<double>& other) {
      return source.contains(key) ? source[key].get<std::vector<double>>() : other;
    };
    const auto t = numbers("translation", {0, 0, 0}), s = numbers("scale", {1, 1, 1});
    const auto q = numbers("rotation", {0, 0, 0, 1});
    // v + 2 w (u x v) + 2 u x (u x v) of the unit vectors.
    Matrix m = {};
    for (std::size_t j = 0; j < 3; ++j) {
      const auto cross = [&](const std::array<long double, 3>& v) {
        return std::array<long double, 3>{q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2],
                                          q[0] * v[1] - q[1] * v[0]};
      };
      std::array<long double, 3> v = {};
      v[j] = 1;
      const auto uv = cross(v), uuv = cross(uv);
      for (std::size_t i = 0; i < 3; ++i) m[i][j] = (v[i] + 2 * (q[3] * uv[i] + uuv[i])) * s[j];
    }
    for (std::size_t i = 0; i < 3; ++i) m[i][3] = t[i];
    m[3][3] = 1;
    for (std::size_t parent = 0; parent < root["nodes"].size(); ++parent) {
      const json& candidate = root["nodes"][parent];
      if (!candidate.contains("children")) continue;
      for (const json& child : candidate["children"]) {
        if (child == node) return product(world(parent), m);
      }
    }
    return m;
  }

  json root;

 private:
  const std::byte* binary_ = nullptr;
};

TEST(SkinnedFile, stands_as_an_independent_computation_says) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const auto path = *data / "scenes" / "knight_skinned.glb";
  const auto bytes = test::read_bytes(path);
  const RawGlb raw(bytes);
  const auto scene = import_file(path, {});
  ASSERT_TRUE(scene.ok()) << scene.error().message;

  const json& skin = raw.root["skins"][0];
  std::vector<Matrix> joints;
  for (std::size_t k = 0; k < skin["joints"].size(); ++k) {
    Matrix bind;
    for (std::size_t c = 0; c < 16; ++c) {
      bind[c % 4][c / 4] = raw.number(skin["inverseBindMatrices"], k, c);
    }
    joints.push_back(product(raw.world(skin["joints"][k]), bind));
  }
  std::size_t skinned = 0, vertices = 0;
  for (const Instance& instance : scene->instances) {
    const json& node = raw.root["nodes"][scene->nodes[instance.node].file_node];
    if (!node.contains("skin")) continue;
    ++skinned;
    EXPECT_TRUE(instance.world_from_mesh.is_identity());
    const json& primitive =
        raw.root["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0]["attributes"];
    const SharedColumn<Vec3f>& ours = scene->meshes[instance.mesh]->positions;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      Matrix blend = {};
      for (std::size_t k = 0; k < 4; ++k) {
        const long double weight = raw.number(primitive["WEIGHTS_0"], i, k);
        const auto j = static_cast<std::size_t>(raw.number(primitive["JOINTS_0"], i, k));
        for (std::size_t r = 0; r < 3; ++r) {
          for (std::size_t c = 0; c < 4; ++c) blend[r][c] += weight * joints[j][r][c];
        }
      }
      for (std::size_t r = 0; r < 3; ++r) {
        long double wanted = blend[r][3], size = std::fabs(blend[r][3]);
        for (std::size_t c = 0; c < 3; ++c) {
          const long double term = blend[r][c] * raw.number(primitive["POSITION"], i, c);
          wanted += term;
          size += std::fabs(term);
        }
        // Half an ulp of float32 for the rounding, and float64's errors in a chain of eleven nodes.
        const long double bound = std::fabs(wanted) * 0x1p-24L + size * 0x1p-44L;
        EXPECT_LE(std::fabs(static_cast<long double>(ours[i][static_cast<int>(r)]) - wanted), bound)
            << node["name"] << " vertex " << i;
        ++vertices;
      }
    }
  }
  EXPECT_EQ(skinned, 6u);
  EXPECT_GT(vertices, 6000u);
}

}  // namespace
}  // namespace sightline
