// Inside and outside of boxes, where the answer is known without any ray.

#include "core/run/inside.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <initializer_list>
#include <memory>

#include "core/run/engine.h"
#include "tests/oracle/random.h"

namespace sightline {
namespace {

constexpr std::uint64_t kInsideSeed = 65;

struct Solid {
  int low[3], high[3];
};

/// The twelve triangles of a box, their fronts outwards; `lid` false leaves two of them out.
void add_box(Mesh& mesh, const Solid& solid, bool lid = true) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int corner = 0; corner < 8; ++corner) {
    const auto x = [&](int k) {
      return static_cast<float>((corner >> k & 1) != 0 ? solid.high[k] : solid.low[k]);
    };
    mesh.positions.own().push_back({x(0), x(1), x(2)});
  }
  // Two triangles for each face, counter-clockwise from outside; the last face is z high.
  constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& face : kFaces) {
    if (!lid && &face == &kFaces[5]) continue;
    for (const std::uint32_t corner : {face[0], face[1], face[2], face[0], face[2], face[3]})
      mesh.indices.own().push_back(first + corner);
  }
}

std::shared_ptr<const Scene> scene_of(std::shared_ptr<Mesh> mesh) {
  mesh->primitives.push_back({0, mesh->triangle_count(), 0, kNone});
  SceneDescription description;
  description.meshes = {std::move(mesh)};
  description.nodes.push_back({});
  description.instances.push_back({});
  return *Scene::build(std::move(description));
}

TEST(Inside, is_what_is_known_of_overlapping_boxes) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(kInsideSeed));
  oracle::Random random(kInsideSeed);
  const auto engine = *Engine::create({2, ""});
  std::size_t on_surface = 0, inside = 0, deep = 0;
  for (int round = 0; round < 20; ++round) {
    auto mesh = std::make_shared<Mesh>();
    std::vector<Solid> solids(6);
    for (Solid& solid : solids) {
      for (int k = 0; k < 3; ++k) {
        solid.low[k] = random.integer(-4, 2);
        solid.high[k] = solid.low[k] + random.integer(3, 8);
      }
      add_box(*mesh, solid);
    }
    const auto scene = scene_of(mesh);
    // Points on the grid of the corners and in the middle between: many on faces, edges, corners.
    Column<Vec3d> points;
    for (int i = 0; i < 1000; ++i) {
      const auto x = [&] { return random.integer(-10, 14) / 2.0; };
      points.push_back({x(), x(), x()});
    }
    for (const InsideMethod method : {InsideMethod::kParity, InsideMethod::kWinding}) {
      InsideAnswers answers;
      ASSERT_TRUE(engine->inside(*scene, points, method, Deadline::never(), answers));
      for (std::size_t i = 0; i < points.size(); ++i) {
        std::int64_t around = 0;
        bool touches = false;
        for (const Solid& solid : solids) {
          bool in = true, closed = true;
          for (int k = 0; k < 3; ++k) {
            in = in && points[i][k] > solid.low[k] && points[i][k] < solid.high[k];
            closed = closed && points[i][k] >= solid.low[k] && points[i][k] <= solid.high[k];
          }
          around += in ? 1 : 0;
          touches = touches || (closed && !in);
        }
        ASSERT_EQ(answers.on_surface[i] != 0, touches) << i;
        ASSERT_TRUE(answers.reliable[i]);
        if (touches) {
          ++on_surface;
          continue;
        }
        const bool expected = method == InsideMethod::kParity ? around % 2 != 0 : around > 0;
        ASSERT_EQ(answers.inside[i] != 0, expected) << i;
        if (method == InsideMethod::kWinding) {
          ASSERT_EQ(answers.winding[i], around);
        }
        inside += expected ? 1u : 0u;
        deep += around > 1 ? 1u : 0u;
      }
    }
  }
  std::printf("on a surface %zu, inside %zu, in several %zu\n", on_surface, inside, deep);
  EXPECT_GT(on_surface, 1000u);
  EXPECT_GT(inside, 1000u);
  EXPECT_GT(deep, 500u);
}

TEST(Inside, says_that_an_open_box_is_not_reliable) {
  auto mesh = std::make_shared<Mesh>();
  add_box(*mesh, {{0, 0, 0}, {2, 2, 2}}, false);
  const auto scene = scene_of(mesh);
  const auto engine = *Engine::create({1, ""});
  InsideAnswers answers;
  // The third direction leaves by the lid, the others do not.
  ASSERT_TRUE(engine->inside(*scene, {{1, 1, 1.5}, {9, 9, 9}}, InsideMethod::kParity,
                             Deadline::never(), answers));
  EXPECT_EQ(answers.reliable, (Column<std::uint8_t>{0, 1}));
}

TEST(Inside, counts_edges_within_the_time_and_the_memory_that_there_is) {
  // Two primitives, of which one counts: what is known of the whole mesh does not help.
  auto mesh = std::make_shared<Mesh>();
  add_box(*mesh, {{0, 0, 0}, {2, 2, 2}});
  mesh->primitives = {{0, 6, 0, 0}, {6, 6, 1, 1}};
  SceneDescription description;
  description.meshes = {std::move(mesh)};
  description.nodes.push_back({});
  description.instances.push_back({});
  const auto scene = *Scene::build(std::move(description));
  ResolvedFilter kept;
  kept.first = {0};
  kept.sides = {ResolvedFilter::kAll, 0};
  CancelFlag gone;
  gone.cancel();
  const Deadline cancelled = Deadline::in(std::chrono::hours(1), &gone);
  const ReserveBytes refuses = [](std::uint64_t) {
    return Error{ErrorKind::kBusy, "MEMORY_BUSY", "", ""};
  };
  for (const ResolvedFilter* which : std::initializer_list<const ResolvedFilter*>{nullptr, &kept}) {
    const auto edges = [&](const Deadline& deadline, const ReserveBytes& reserve) {
      return open_edges(*scene, which, InsideMethod::kParity, deadline, reserve);
    };
    EXPECT_EQ(edges(cancelled, {}).error().code, "CANCELLED");
    EXPECT_EQ(edges(Deadline::in({}), {}).error().code, "DEADLINE");
    EXPECT_EQ(edges(Deadline::never(), refuses).error().code, "MEMORY_BUSY");
    const auto open = edges(Deadline::never(), {});
    ASSERT_TRUE(open.ok());
    EXPECT_EQ(*open > 0, which != nullptr);
  }
  // Once it is known, nothing is taken.
  EXPECT_TRUE(open_edges(*scene, nullptr, InsideMethod::kParity, Deadline::never(), refuses).ok());
}

}  // namespace
}  // namespace sightline
