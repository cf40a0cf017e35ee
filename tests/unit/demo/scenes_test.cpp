#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/demo/demo.h"
#include "core/demo/random.h"
#include "core/demo/shapes.h"
#include "tests/support/golden_hash.h"

namespace sightline::demo {
namespace {

std::uint64_t unique_triangles(const DemoScene& scene) {
  std::uint64_t count = 0;
  for (const DemoMesh& mesh : scene.meshes) count += mesh.indices.size() / 3;
  return count;
}

std::uint64_t placed_triangles(const DemoScene& scene) {
  std::uint64_t count = 0;
  for (const DemoNode& node : scene.nodes) {
    if (node.mesh >= 0)
      count += scene.meshes[static_cast<std::size_t>(node.mesh)].indices.size() / 3;
  }
  return count;
}

const DemoNode* find_node(const DemoScene& scene, const std::string& name) {
  const auto found = std::find_if(scene.nodes.begin(), scene.nodes.end(),
                                  [&](const DemoNode& node) { return node.name == name; });
  return found == scene.nodes.end() ? nullptr : &*found;
}

/// Every directed edge once, and its reverse once: closed and consistently wound.
bool closed(const DemoMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    ++edges[{mesh.indices[i], mesh.indices[next]}];
  }
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto back = edges.find({edge.first.second, edge.first.first});
    return edge.second == 1 && back != edges.end() && back->second == 1;
  });
}

/// Six times the enclosed volume: positive when triangles are counter-clockwise from outside.
double signed_volume(const DemoMesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    double p[3][3];
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        p[k][c] = static_cast<double>(mesh.positions[std::size_t{mesh.indices[i + k]} * 3 + c]);
      }
    }
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
           p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum;
}

void expect_sound(const DemoScene& scene) {
  SCOPED_TRACE(scene.name);
  for (const DemoMesh& mesh : scene.meshes) {
    ASSERT_FALSE(mesh.indices.empty()) << mesh.name;
    ASSERT_EQ(mesh.indices.size() % 3, 0u);
    ASSERT_EQ(mesh.positions.size() % 3, 0u);
    EXPECT_LT(*std::max_element(mesh.indices.begin(), mesh.indices.end()),
              mesh.positions.size() / 3);
    EXPECT_TRUE(std::all_of(mesh.positions.begin(), mesh.positions.end(),
                            [](float v) { return std::isfinite(v); }));
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_LT(scene.nodes[i].parent, static_cast<int>(i));
    EXPECT_LT(scene.nodes[i].mesh, static_cast<int>(scene.meshes.size()));
  }
}

TEST(DemoScenes, are_sound_and_of_the_size_that_was_asked_for) {
  for (std::uint32_t triangles : {1000u, 20000u}) {
    const double wanted = triangles;
    for (const DemoScene& scene :
         {terrain(triangles), soup(triangles), city(triangles), sphere(triangles)}) {
      expect_sound(scene);
      EXPECT_NEAR(static_cast<double>(unique_triangles(scene)), wanted, wanted * 0.1) << scene.name;
    }
    EXPECT_EQ(unique_triangles(soup(triangles)), triangles);
    EXPECT_LE(triangles - unique_triangles(city(triangles)), 1u);
  }
  expect_sound(instances(100, 300));
  expect_sound(town());
  expect_sound(six_triangles());
  expect_sound(painted_square());
}

TEST(DemoScenes, place_one_ball_many_times) {
  const DemoScene scene = instances(1000, 1200);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.nodes.size(), 1000u);
  EXPECT_EQ(placed_triangles(scene), 1000u * unique_triangles(scene));
}

TEST(DemoScenes, change_with_the_seed_and_repeat_with_it) {
  EXPECT_EQ(write_glb(soup(100, 5)), write_glb(soup(100, 5)));
  EXPECT_NE(write_glb(soup(100, 5)), write_glb(soup(100, 6)));
  EXPECT_NE(write_glb(terrain(200, 5)), write_glb(terrain(200, 6)));
  EXPECT_NE(write_glb(city(2000, 5)), write_glb(city(2000, 6)));
  EXPECT_NE(write_glb(instances(10, 48, 5)), write_glb(instances(10, 48, 6)));
  EXPECT_NE(write_glb(town(5)), write_glb(town(6)));
}

TEST(DemoScenes, are_the_same_bytes_on_every_machine_and_compiler) {
  const auto hash = [](const DemoScene& scene) { return test::golden_hash(write_glb(scene)); };
  EXPECT_EQ(hash(six_triangles()), 0x502cb1e203244bacu);
  EXPECT_EQ(hash(town()), 0x188a22eeac9055feu);
  EXPECT_EQ(hash(terrain(5000)), 0xe7867202ce336a37u);
  EXPECT_EQ(hash(soup(5000)), 0x7a0c173df5b3099fu);
  EXPECT_EQ(hash(city(20000)), 0x84f22715569db1d2u);
  EXPECT_EQ(hash(sphere(1200)), 0x5859994648457b4au);
  EXPECT_EQ(hash(instances(100, 300)), 0xe37a25f623ce5e80u);
}

TEST(Shapes, are_wound_outwards) {
  DemoMesh box, frustum, cone, tube;
  add_box(box, {-1, -2, -3}, {4, 5, 6});
  add_column(frustum, {4, 7, -7, 0, 3, 1, 0.5});
  add_column(cone, {8, 7, -7, 0, 3, 1, 0});
  for (const DemoMesh& mesh : {box, frustum, cone}) {
    EXPECT_TRUE(closed(mesh));
    EXPECT_GT(signed_volume(mesh), 0);
  }
  EXPECT_EQ(signed_volume(box), 6 * 5 * 7 * 9);
  for (const Vec3d& end : {Vec3d{9, 1, 0}, Vec3d{-9, 1, 0}, Vec3d{1, 2, 9}, Vec3d{1, 2, -9}}) {
    const Vec3d points[2] = {{0, 0, 0}, end};
    tube = {};
    add_tube(tube, points, 2, 0.5);
    EXPECT_EQ(tube.indices.size() / 3, 8u);
    EXPECT_GT(signed_volume(tube), 0);
  }
}

TEST(Ball, is_closed_and_wound_outwards) {
  const DemoMesh ball = sphere(1200).meshes[0];
  EXPECT_TRUE(closed(ball));
  EXPECT_GT(signed_volume(ball), 0);
}

TEST(Town, has_about_the_size_that_its_header_states) {
  const DemoScene scene = town();
  EXPECT_EQ(unique_triangles(scene), 52078u);
  EXPECT_EQ(placed_triangles(scene), 362254u);
}

struct Met {
  std::string node;
  double t = std::numeric_limits<double>::infinity();
};

/// Every triangle by plain float64 arithmetic: good enough for rays that are easy to check.
Met first_met(const DemoScene& scene, const Vec3d& o, const Vec3d& d) {
  Met met;
  std::vector<Affine> world(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const DemoNode& node = scene.nodes[i];
    world[i] = node.parent < 0
                   ? node.parent_from_node
                   : world[static_cast<std::size_t>(node.parent)] * node.parent_from_node;
    if (node.mesh < 0) continue;
    const DemoMesh& mesh = scene.meshes[static_cast<std::size_t>(node.mesh)];
    const auto corner = [&](std::uint32_t v) {
      const float* p = &mesh.positions[std::size_t{v} * 3];
      return world[i].apply(Vec3f{p[0], p[1], p[2]});
    };
    const auto minus = [](const Vec3d& a, const Vec3d& b) {
      return Vec3d{a.x - b.x, a.y - b.y, a.z - b.z};
    };
    const auto cross = [](const Vec3d& a, const Vec3d& b) {
      return Vec3d{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    };
    const auto dot = [](const Vec3d& a, const Vec3d& b) {
      return a.x * b.x + a.y * b.y + a.z * b.z;
    };
    for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
      const Vec3d v0 = corner(mesh.indices[k]);
      const Vec3d e1 = minus(corner(mesh.indices[k + 1]), v0);
      const Vec3d e2 = minus(corner(mesh.indices[k + 2]), v0);
      const Vec3d s = minus(o, v0), p = cross(d, e2), q = cross(s, e1);
      const double det = dot(e1, p), u = dot(s, p) / det, v = dot(d, q) / det;
      const double t = dot(e2, q) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t < met.t) met = {node.name, t};
    }
  }
  return met;
}

TEST(Town, is_met_where_its_header_says) {
  const DemoScene scene = town();
  const Met wall = first_met(scene, {-40, 12, 1}, {1, 0, 0});
  EXPECT_EQ(wall.node, "clock tower");
  EXPECT_EQ(wall.t, 37);
  const Met tip = first_met(scene, {0, 100, 0}, {0, -1, 0});
  EXPECT_EQ(tip.node, "spire");
  EXPECT_EQ(tip.t, 68);
}

TEST(SixTriangles, has_the_four_branches_of_the_lecture_notes) {
  const DemoScene scene = six_triangles();
  EXPECT_EQ(unique_triangles(scene), 6u);
  const Met both = first_met(scene, {-10, 1, 0}, {1, 0, 0});
  EXPECT_EQ(both.node, "left");
  EXPECT_EQ(both.t, 4.5);
  const Met left = first_met(scene, {-5, 10, 0}, {0, -1, 0});
  EXPECT_EQ(left.node, "left");
  EXPECT_EQ(left.t, 8);
  const Met right = first_met(scene, {3, 10, 0}, {0, -1, 0});
  EXPECT_EQ(right.node, "right");
  EXPECT_EQ(right.t, 8);
  EXPECT_EQ(first_met(scene, {1, 10, 0}, {0, -1, 0}).node, "");
}

TEST(PaintedSquare, is_met_where_its_header_says_and_has_attributes_of_each_vertex) {
  const DemoScene scene = painted_square();
  EXPECT_EQ(unique_triangles(scene), 2u);
  const Met met = first_met(scene, {0.5, -0.5, 5}, {0, 0, -1});
  EXPECT_EQ(met.node, "square");
  EXPECT_EQ(met.t, 5);
  const DemoMesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.normals.size(), 4u * 3);
  EXPECT_EQ(mesh.uvs.size(), 4u * 2);
  EXPECT_EQ(mesh.colours.size(), 4u * 4);
}

TEST(Town, names_its_parts) {
  const DemoScene scene = town();
  for (const char* name :
       {"town", "terrain", "clock tower", "spire", "market square", "house 3", "roof of house 3",
        "tree 17", "pine 900", "street 1", "avenue 5", "lamp 7"}) {
    EXPECT_NE(find_node(scene, name), nullptr) << name;
  }
  EXPECT_EQ(scene.meshes[static_cast<std::size_t>(find_node(scene, "tree 17")->mesh)].name, "tree");
  std::set<std::string> names;
  for (const DemoNode& node : scene.nodes) {
    EXPECT_TRUE(names.insert(node.name).second) << node.name << " stands for two nodes";
  }
}

TEST(Town, has_closed_solids_wound_outwards) {
  const DemoScene scene = town();
  for (const DemoMesh& mesh : scene.meshes) {
    if (mesh.name == "terrain") continue;
    EXPECT_TRUE(closed(mesh)) << mesh.name;
    EXPECT_GT(signed_volume(mesh), 0) << mesh.name;
  }
}

TEST(RandomTurn, is_a_rotation_for_every_seed) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    for (const Affine& r : {random_turn(random), random_rotation(random)}) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          double dot = 0;
          for (int k = 0; k < 3; ++k) dot += r.m[i][k] * r.m[j][k];
          EXPECT_NEAR(dot, i == j ? 1 : 0, 1e-12);
        }
      }
    }
  }
}

TEST(RandomSpread, stays_inside_its_range_and_reaches_both_ends) {
  Random random(1);
  int small = 0, large = 0;
  for (int i = 0; i < 10000; ++i) {
    const double size = random.spread(0.1, 40);
    ASSERT_GE(size, 0.1);
    ASSERT_LT(size, 40);
    small += size < 1 ? 1 : 0;
    large += size > 10 ? 1 : 0;
  }
  EXPECT_GT(small, 1000);
  EXPECT_GT(large, 1000);
}

}  // namespace
}  // namespace sightline::demo
