#include "core/import/pov/pov_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/import/import.h"
#include "core/run/engine.h"
#include "core/scene/scene.h"
#include "tests/support/data_folder.h"

namespace sightline {
namespace {

Result<SceneDescription> read(std::string_view text, const ImportLimits& limits = {}) {
  return pov::import_boxes(text, limits);
}

std::string code(std::string_view text) {
  const auto scene = read(text);
  return scene ? "" : scene.error().code;
}

TEST(PovScene, places_boxes_with_corners_in_either_order) {
  const auto scene = read("box { <4, 0.5, 2>, <2, -1.5, -2> }\nbox{<-.5,+1e1,0>,<0,11,1>}");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->instances.size(), 2u);
  EXPECT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->instances[0].world_from_mesh.apply(Vec3d{0, 0, 0}), (Vec3d{2, -1.5, -2}));
  EXPECT_EQ(scene->instances[0].world_from_mesh.apply(Vec3d{1, 1, 1}), (Vec3d{4, 0.5, 2}));
  EXPECT_EQ(scene->instances[1].world_from_mesh.apply(Vec3d{0, 0, 0}), (Vec3d{-0.5, 10, 0}));
  EXPECT_EQ(scene->nodes[1].name, "box, line 2");
}

TEST(PovScene, gives_corners_to_the_last_bit) {
  const auto scene = read("box { <-41.4439, 0.1, 1e-9>, <-39.3179, 1.3724, 38.5515> }");
  ASSERT_TRUE(scene.ok());
  const Affine& matrix = scene->instances[0].world_from_mesh;
  EXPECT_EQ(matrix.apply(Vec3d{0, 0, 0}), (Vec3d{-41.4439, 0.1, 1e-9}));
  EXPECT_EQ(matrix.apply(Vec3d{1, 1, 1}), (Vec3d{-39.3179, 1.3724, 38.5515}));
}

TEST(PovScene, keeps_a_pigment_as_the_name_of_a_material) {
  const auto scene = read(
      "box { <0,0,0>, <1,1,1> pigment { rgb <1, 0.5, 0> } finish { phong 0.5 } no_shadow }\n"
      "box { <0,0,0>, <2,2,2> pigment { rgb <1, 0.5, 0> } }\n"
      "box { <0,0,0>, <3,3,3> texture { pigment { rgb x } } }");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->materials.size(), 2u);
  EXPECT_EQ(scene->materials[0].name, "{ rgb <1, 0.5, 0> }");
  EXPECT_EQ(scene->materials[1].name, "{ rgb x }");
  EXPECT_EQ(scene->instances[0].mesh, scene->instances[1].mesh);
  EXPECT_EQ(scene->meshes[1]->primitives[0].material, 1u);
}

TEST(PovScene, skips_comments_strings_and_what_is_no_geometry) {
  const auto scene = read(
      "// box { <9,9,9>, <10,10,10> }\n#version 3.7;\n/* box /* nested */ { */\n"
      "camera { location <0, 2, -10> look_at <0, 0, 0> }\n"
      "global_settings { assumed_gamma 1.0 }\nlight_source { <1,2,3> rgb 1 }\n"
      "box { <0,0,0>, /* inside */ <1,1,1> texture { image_map { png \"a}b.png\" } } }");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->instances.size(), 1u);
  EXPECT_EQ(scene->nodes[0].name, "box, line 7");
}

TEST(PovScene, refuses_what_it_would_place_wrongly_and_names_the_line) {
  const auto scene = read("#version 3.7;\nbox { <0,0,0>, <1,1,1> rotate <0, 45, 0> }");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().kind, ErrorKind::kUnsupported);
  EXPECT_EQ(scene.error().code, "POV_FEATURE_UNSUPPORTED");
  EXPECT_EQ(scene.error().message,
            "line 2: \"rotate\" is not understood, only boxes without transforms are");
  for (const char* text : {"sphere { <0,0,0>, 1 }", "#declare A = 1;", "#include \"colors.inc\"",
                           "box { <0,0,0>, <1,1,1> translate x }", "box { <0,0,0>, <1,Width,1> }",
                           "union { box { <0,0,0>, <1,1,1> } }"}) {
    EXPECT_EQ(code(text), "POV_FEATURE_UNSUPPORTED") << text;
  }
}

TEST(PovScene, refuses_broken_texts) {
  for (const char* text :
       {"box", "box {", "box { <0,0,0>", "box { <0,0,0>, <1,1> }", "box { <0 0 0>, <1,1,1> }",
        "box { <0,0,0>, <1,1,1>", "box { <0,0,0>, <1,1,1> pigment }", "/* no end", "camera {",
        "box { <0,0,0>, <1,1,1e999> }", "box { <0,0,0>, <1,1,1e39> }", "}", "#version 3.7",
        "box { <0,0,0>, <1,1,1> texture { image_map { png \"a } } }"}) {
    EXPECT_EQ(code(text), "POV_SYNTAX_INVALID") << text;
  }
}

TEST(PovScene, keeps_its_limits) {
  const std::string box = "box { <0,0,0>, <1,1,1> }";
  ImportLimits limits;
  limits.instances = 1;
  EXPECT_TRUE(read(box, limits).ok());
  EXPECT_EQ(read(box + box, limits).error().code, "GLTF_LIMIT_INSTANCES");
  limits = {};
  limits.json_bytes = 10;
  EXPECT_EQ(read(box, limits).error().code, "GLTF_LIMIT_JSON_BYTES");
  limits = {};
  limits.geometry_bytes = 100;
  EXPECT_EQ(read(box, limits).error().code, "GLTF_LIMIT_GEOMETRY_BYTES");
  const std::string deep = "camera " + std::string(300, '{') + std::string(300, '}');
  EXPECT_EQ(read(deep).error().code, "GLTF_LIMIT_JSON_DEPTH");
}

TEST(PovScene, is_known_by_how_it_begins) {
  EXPECT_TRUE(pov::looks_like_pov("// a scene\n#version 3.7;"));
  EXPECT_TRUE(pov::looks_like_pov("/* a scene */ box {"));
  EXPECT_TRUE(pov::looks_like_pov("camera {"));
  for (const char* text : {"", " ", "{\"asset\":1}", "glTF", "hello", "// only a comment", "/*"}) {
    EXPECT_FALSE(pov::looks_like_pov(text)) << text;
  }
}

/// Of a face of a box: one axis, sign and all.
Vec3d normal_of(const Scene& scene, TriangleId id) {
  const WorldTriangle triangle = scene.world_triangle(id);
  const auto edge = [&](const Vec3d& to) {
    return Vec3d{to.x - triangle.v0.x, to.y - triangle.v0.y, to.z - triangle.v0.z};
  };
  const Vec3d a = edge(triangle.v1), b = edge(triangle.v2);
  const auto sign = [](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; };
  return {sign(a.y * b.z - a.z * b.y), sign(a.z * b.x - a.x * b.z), sign(a.x * b.y - a.y * b.x)};
}

/// POV-Ray's own answers: origin, unit direction, distance and normal of 2,000 rays each.
class PovAnswers : public testing::TestWithParam<const char*> {};

TEST_P(PovAnswers, agree_with_ours) {
  const auto data = test::data_folder();
  if (!data) GTEST_SKIP() << "no shared data folder (set SIGHTLINE_DATA)";
  const std::string name = GetParam();
  auto description = import_file(*data / "pov" / (name + ".pov"), {});
  ASSERT_TRUE(description.ok()) << description.error().message;
  const auto scene = Scene::build(*std::move(description));
  ASSERT_TRUE(scene.ok());
  const auto engine = Engine::create({.threads = 1, .kernel = ""});
  ASSERT_TRUE(engine.ok());

  RayBatch rays;
  std::vector<nlohmann::json> answers;
  std::ifstream in(*data / "pov" / (name + ".ref.jsonl"));
  for (std::string line; std::getline(in, line);) {
    answers.push_back(nlohmann::json::parse(line));
    const auto o = answers.back()["o"].get<std::vector<double>>();
    const auto d = answers.back()["d"].get<std::vector<double>>();
    rays.push_back(
        {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, 0, std::numeric_limits<double>::infinity()});
  }
  ASSERT_EQ(answers.size(), 2000u);
  HitBatch hits;
  ASSERT_TRUE((*engine)->closest(**scene, rays, Deadline::never(), hits).ok());
  // Two boxes may share a face: then either normal is right, and POV-Ray need not name ours.
  HitLists lists;
  Column<std::uint64_t> totals;
  ASSERT_TRUE((*engine)
                  ->all(**scene, rays, {Crossings::kEvery, 100, 1'000'000}, Deadline::never(),
                        lists, totals)
                  .ok());
  std::size_t met = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    SCOPED_TRACE("ray " + std::to_string(i));
    const bool hit = hits.instance[i] != 0xffffffffu;
    ASSERT_EQ(hit, !answers[i]["t"].is_null());
    if (!hit) continue;
    ++met;
    const double t = answers[i]["t"].get<double>();
    const double size =
        t + std::max({std::fabs(rays.ox[i]), std::fabs(rays.oy[i]), std::fabs(rays.oz[i])});
    EXPECT_NEAR(hits.t[i], t, 2.5e-15 * size) << "POV-Ray computes with coordinates of that size";
    const auto n = answers[i]["n"].get<std::vector<double>>();
    bool agrees = false;
    for (std::size_t k = lists.first[i]; k < lists.first[i + 1] && lists.hits.t[k] == hits.t[i];
         ++k) {
      agrees = agrees || normal_of(**scene, lists.hits.id(k)) == Vec3d{n[0], n[1], n[2]};
    }
    EXPECT_TRUE(agrees) << answers[i].dump();
  }
  EXPECT_GT(met, 500u);
}

INSTANTIATE_TEST_SUITE_P(Files, PovAnswers,
                         testing::Values("boxes_simple", "boxes_overlap", "boxes_town"));

}  // namespace
}  // namespace sightline
