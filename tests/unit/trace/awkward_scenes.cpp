#include "tests/unit/trace/awkward_scenes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline::test {

Affine affine(std::initializer_list<double> rows) {
  Affine a;
  auto it = rows.begin();
  for (auto& row : a.m) {
    for (double& x : row) x = *it++;
  }
  return a;
}

std::vector<Case> cases() {
  const Affine same;
  const Affine turned = affine({0.6, -0.8, 0, 5, 0.8, 0.6, 0, -1, 0, 0, 1, 2});
  const Affine mirrored = affine({-1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0.5, 1});
  const Affine sheared = affine({1, 1e4, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  const Affine flat = affine({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 3});
  const Affine far = affine({1, 0, 0, 1e8, 0, 1, 0, -1e8, 0, 0, 1, 0});
  return {{"one mesh", 1, 0, false, {}},
          {"one mesh on a grid", 1, 0, true, {}},
          {"one turned mesh", 1, 0, false, {turned}},
          {"many placements on a grid", 1, 0, true, {same, turned, mirrored, same, flat}},
          {"awkward placements", 1, 0, false, {sheared, mirrored, far, turned, flat, same}},
          {"tiny", 1e-30f, 0, true, {}},
          {"tiny placements", 1e-30f, 0, false, {same, mirrored}},
          {"denormal", 1e-42f, 0, true, {}},
          {"huge", 1e30f, 0, false, {same, turned}},
          {"shifted", 1, 1e6f, false, {}},
          {"many placements on a grid, each on its own",
           1,
           0,
           true,
           {same, turned, mirrored, same, flat},
           Joining::kNever},
          {"awkward placements, each on its own",
           1,
           0,
           false,
           {sheared, mirrored, far, turned, flat, same},
           Joining::kNever}};
}

std::shared_ptr<const Scene> make_scene(const Case& c, oracle::Random& random) {
  auto mesh = std::make_shared<Mesh>();
  const auto coordinate = [&] {
    const double x = c.grid ? random.integer(-3, 3) : random.between(-3, 3);
    return static_cast<float>(x) * c.scale + c.shift;
  };
  for (std::uint32_t i = 0; i < 100; ++i) {
    const float x = coordinate(), y = coordinate();
    mesh->positions.own().push_back({x, y, coordinate()});
  }
  // Small triangles beside large ones, duplicates, and some without area.
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      mesh->indices.own().push_back(static_cast<std::uint32_t>(random.index(100)));
    }
  }
  // Rays are never mapped into a mesh that has one.
  if (c.joining != Joining::kNever)
    mesh->positions.own()[7].x = std::numeric_limits<float>::quiet_NaN();
  mesh->primitives.push_back({0, kTriangles, 0, 0xffffffffu});
  SceneDescription description;
  description.meshes.push_back(mesh);
  const std::vector<Affine> places = c.places.empty() ? std::vector<Affine>{{}} : c.places;
  for (const Affine& place : places) {
    // Two instances share a node now and then.
    if (description.nodes.empty() || random.chance(0.7)) description.nodes.push_back({});
    description.instances.push_back(
        {0, static_cast<std::uint32_t>(description.nodes.size() - 1), place});
  }
  auto scene = Scene::build(std::move(description), TreeQuality::kHigh, c.joining);
  EXPECT_TRUE(scene.ok());
  return *scene;
}

}  // namespace sightline::test
