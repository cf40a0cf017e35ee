#include <algorithm>
#include <cmath>

#include "core/demo/demo.h"
#include "core/demo/random.h"
#include "core/demo/shapes.h"

// Metres, y up, x east, z south. The town stands on level ground around the origin; hills rise
// beyond. Streets run along multiples of 50 m; the clock tower stands in the middle.

namespace sightline::demo {

namespace {

constexpr double kHalf = 400;       ///< the terrain reaches from -400 to 400
constexpr double kLevel = 140;      ///< radius of the level ground
constexpr double kHills = 330;      ///< from here on the hills have their full height
constexpr double kStreetEnd = 120;  ///< streets reach from -120 to 120
constexpr int kHouseTypes = 6, kTrees = 700, kPines = 900;

double ground_height(double x, double z, std::uint64_t seed) {
  const double s = (std::sqrt(x * x + z * z) - kLevel) / (kHills - kLevel);
  const double t = std::clamp(s, 0.0, 1.0);
  const double rise = t * t * (3 - 2 * t);
  return rise == 0 ? 0 : rise * (35 + 75 * fractal_noise(x, z, 160, 6, seed));
}

/// Distance from the nearer of the street's centre lines, which lie at multiples of 50.
double to_street_line(double x) {
  const double r = std::fabs(x) - 50 * std::floor(std::fabs(x) / 50);
  return std::min(r, 50 - r);
}

/// Scene under construction: meshes are added once, nodes by name.
struct Plan {
  DemoScene scene;

  int add_mesh(DemoMesh mesh, std::string name, std::string material) {
    mesh.name = std::move(name);
    mesh.material = std::move(material);
    scene.meshes.push_back(std::move(mesh));
    return static_cast<int>(scene.meshes.size()) - 1;
  }
  int add_node(std::string name, int parent, int mesh = -1, const Affine& placed = {}) {
    scene.nodes.push_back({std::move(name), parent, mesh, placed});
    return static_cast<int>(scene.nodes.size()) - 1;
  }
};

DemoMesh slab(const Vec3d& min, const Vec3d& max) {
  DemoMesh mesh;
  add_box(mesh, min, max);
  return mesh;
}

/// A gable roof along x over [-hx, hx] x [-hz, hz], from `eaves` to `ridge`; a chimney on it.
DemoMesh gable_roof(double hx, double hz, double eaves, double ridge) {
  DemoMesh mesh;
  const std::uint32_t a = add_vertex(mesh, -hx, eaves, -hz), b = add_vertex(mesh, -hx, eaves, hz),
                      c = add_vertex(mesh, hx, eaves, hz), d = add_vertex(mesh, hx, eaves, -hz),
                      e = add_vertex(mesh, -hx, ridge, 0), f = add_vertex(mesh, hx, ridge, 0);
  add_quad(mesh, b, c, f, e);
  add_quad(mesh, d, a, e, f);
  add_triangle(mesh, a, b, e);
  add_triangle(mesh, c, d, f);
  add_quad(mesh, a, d, c, b);
  add_box(mesh, {hx / 2, eaves, -0.4}, {hx / 2 + 0.8, ridge + 1, 0.4});
  return mesh;
}

/// Walls of `type`: a main wing, and for every second type a side wing. Sizes are half metres.
DemoMesh walls(int type, double hx, double hz, double eaves) {
  DemoMesh mesh = slab({-hx, -1, -hz}, {hx, eaves, hz});
  if (type % 2 == 1) add_box(mesh, {-hx, -1, hz}, {-hx + 3, 2.5, hz + 2});
  add_box(mesh, {-0.5, 0, -hz - 1}, {0.5, 0.25, -hz});       // doorstep
  add_box(mesh, {-0.5, 0.25, -hz - 0.1}, {0.5, 2.25, -hz});  // entrance
  return mesh;
}

void add_houses(Plan& plan, int root, Random& random) {
  int wall_mesh[kHouseTypes], roof_mesh[kHouseTypes];
  const char* const kWallMaterials[3] = {"brick", "plaster", "timber"};
  for (int type = 0; type < kHouseTypes; ++type) {
    const double hx = 4 + 0.5 * type, hz = 3 + 0.5 * (type % 3), eaves = 3 + 1.5 * (type % 3);
    const std::string letter(1, static_cast<char>('A' + type));
    wall_mesh[type] =
        plan.add_mesh(walls(type, hx, hz, eaves), "house " + letter, kWallMaterials[type % 3]);
    roof_mesh[type] = plan.add_mesh(gable_roof(hx + 0.5, hz + 0.5, eaves, eaves + 3),
                                    "roof " + letter, "roof tiles");
  }
  const int houses = plan.add_node("houses", root);
  int count = 0;
  for (int lot = 0; lot < 64; ++lot) {
    const int column = lot / 2 % 4, row = lot / 16;
    const double x = -75 + 50.0 * column + ((lot & 1) != 0 ? 12 : -12);
    const double z = -75 + 50.0 * row + ((lot / 8 & 1) != 0 ? 12 : -12);
    if (std::fabs(x) < 22 && std::fabs(z) < 22) continue;  // the market square
    const auto type = static_cast<int>(random.below(kHouseTypes));
    // Entrances face the nearest street along z; every fourth house is a mirror image.
    Affine turn;
    const double facing = (lot / 8 & 1) != 0 ? -1 : 1;
    turn.m[0][0] = random.below(4) == 0 ? -facing : facing;
    turn.m[2][2] = facing;
    const std::string name = "house " + std::to_string(++count);
    const int house = plan.add_node(name, houses, wall_mesh[type], translation(x, 0, z) * turn);
    plan.add_node("roof of " + name, house, roof_mesh[type]);
  }
}

void add_streets(Plan& plan, int root) {
  const int street =
      plan.add_mesh(slab({-kStreetEnd, -0.5, -3}, {kStreetEnd, 0.05, 3}), "street", "asphalt");
  const int lamp = [&] {
    DemoMesh mesh;
    add_column(mesh, {8, 0, 0, -0.5, 5, 0.08, 0.05});
    add_box(mesh, {-0.1, 5, -0.1}, {0.7, 5.15, 0.1});
    return plan.add_mesh(std::move(mesh), "lamp", "iron");
  }();
  const int streets = plan.add_node("streets", root), lamps = plan.add_node("lamps", root);
  Affine quarter;  // x to -z: a street that runs north to south
  quarter.m[0][0] = quarter.m[2][2] = 0;
  quarter.m[0][2] = 1;
  quarter.m[2][0] = -1;
  for (int i = -2; i <= 2; ++i) {
    const std::string number = std::to_string(i + 3);
    plan.add_node("street " + number, streets, street, translation(0, 0, 50 * i));
    plan.add_node("avenue " + number, streets, street, translation(50 * i, 0, 0) * quarter);
  }
  int count = 0;
  for (int i = -2; i <= 2; ++i) {
    for (int k = -5; k <= 5; ++k) {
      if (i == 0 && k >= -1 && k <= 1) continue;  // the market square
      plan.add_node("lamp " + std::to_string(++count), lamps, lamp,
                    translation(50 * i + 3.5, 0, 20 * k + 5));
    }
  }
}

void add_tower(Plan& plan, int root) {
  const int square = plan.add_mesh(slab({-20, -0.5, -20}, {20, 0.25, 20}), "square", "cobbles");
  DemoMesh tower = slab({-3, 0, -3}, {3, 24, 3});
  add_box(tower, {-3.5, 18, -3.5}, {3.5, 18.5, 3.5});
  DemoMesh spire;
  for (int i = 0; i < 4; ++i) add_vertex(spire, i % 3 == 0 ? -4 : 4, 24, i < 2 ? 4 : -4);
  const std::uint32_t apex = add_vertex(spire, 0, 32, 0);
  for (std::uint32_t i = 0; i < 4; ++i) add_triangle(spire, i, (i + 1) % 4, apex);
  add_quad(spire, 0, 3, 2, 1);
  const int tower_mesh = plan.add_mesh(std::move(tower), "tower", "sandstone");
  const int spire_mesh = plan.add_mesh(std::move(spire), "spire", "slate");
  plan.add_node("market square", root, square);
  plan.add_node("spire", plan.add_node("clock tower", root, tower_mesh), spire_mesh);
}

DemoMesh tree_mesh() {
  DemoMesh mesh;
  add_ball(mesh, {0, 5, 0}, 2.5, 5);
  add_column(mesh, {8, 0, 0, -1, 3.5, 0.35, 0.25});
  return mesh;
}

DemoMesh pine_mesh() {
  DemoMesh mesh;
  add_column(mesh, {8, 0, 0, -1, 2, 0.3, 0.25});
  for (int i = 0; i < 4; ++i)
    add_column(mesh, {8, 0, 0, 1.5 + 2 * i, 5.0 + 2 * i, 2.4 - 0.4 * i, 0});
  return mesh;
}

/// Trees stand where no street, house or square is, denser in the hills.
void add_trees(Plan& plan, int root, Random& random, std::uint64_t seed) {
  const int meshes[2] = {plan.add_mesh(tree_mesh(), "tree", "leaves"),
                         plan.add_mesh(pine_mesh(), "pine", "needles")};
  const char* const kNames[2] = {"tree ", "pine "};
  const int counts[2] = {kTrees, kPines};
  const int trees = plan.add_node("trees", root);
  for (int kind = 0; kind < 2; ++kind) {
    for (int placed = 0; placed < counts[kind];) {
      const double x = random.between(-kHalf + 5, kHalf - 5);
      const double z = random.between(-kHalf + 5, kHalf - 5);
      const bool in_town = std::fabs(x) < kStreetEnd + 5 && std::fabs(z) < kStreetEnd + 5;
      if (in_town) {
        // Gardens only: the middle of a block, behind its houses and away from the square.
        const bool garden = to_street_line(x) > 21 || to_street_line(z) > 21;
        const bool off_street = to_street_line(x) > 7 && to_street_line(z) > 7;
        if (!garden || !off_street || (std::fabs(x) < 24 && std::fabs(z) < 24)) continue;
      }
      const double size = random.between(0.75, 1.25);
      const Affine where = translation(x, ground_height(x, z, seed), z);
      plan.add_node(kNames[kind] + std::to_string(++placed), trees, meshes[kind],
                    where * (random_turn(random) * scaling(size, size, size)));
    }
  }
}

}  // namespace

DemoScene town(std::uint64_t seed) {
  Random random(seed);
  Plan plan;
  plan.scene.name = "town";
  const int root = plan.add_node("town", -1);
  DemoMesh terrain;
  add_height_field(terrain, kHalf, 160,
                   [&](double x, double z) { return ground_height(x, z, seed); });
  plan.add_node("terrain", root, plan.add_mesh(std::move(terrain), "terrain", "grass"));
  add_tower(plan, root);
  add_streets(plan, root);
  add_houses(plan, root, random);
  add_trees(plan, root, random, seed);
  return std::move(plan.scene);
}

}  // namespace sightline::demo
