// Edges of meshes that are closed, have holes, or turn some triangles the other way.

#include "core/scene/open_edges.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <thread>
#include <vector>

namespace sightline {
namespace {

constexpr auto kAll = [](std::size_t) { return true; };

template <class Counts>
OpenEdges edges_of(const Mesh& mesh, const Counts& counts) {
  return *open_edges(mesh, counts, Deadline::never());
}

/// A tetrahedron whose corners are written anew for every face, so that only positions join them.
Mesh tetrahedron() {
  const Vec3f p[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Mesh mesh;
  for (const auto& face : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    for (const int corner : face) {
      mesh.indices.own().push_back(static_cast<std::uint32_t>(mesh.positions.size()));
      mesh.positions.own().push_back(p[corner]);
    }
  }
  mesh.primitives = {{0, 2, 0, 0}, {2, 2, 1, 1}};
  return mesh;
}

TEST(OpenEdges, of_a_closed_mesh_there_are_none) {
  Mesh mesh = tetrahedron();
  mesh.positions.own()[0].x = -0.0f;
  const OpenEdges edges = edges_of(mesh, kAll);
  EXPECT_EQ(edges.unpaired, 0u);
  EXPECT_EQ(edges.unbalanced, 0u);
}

TEST(OpenEdges, of_a_hole_are_its_rim) {
  Mesh mesh = tetrahedron();
  mesh.primitives[1].triangle_count = 1;
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, 3u);
  EXPECT_EQ(edges_of(mesh, kAll).unbalanced, 3u);
  // Two faces of the four share an edge and leave four.
  EXPECT_EQ(edges_of(tetrahedron(), [](std::size_t p) { return p == 0; }).unpaired, 4u);
}

TEST(OpenEdges, of_a_turned_face_are_unbalanced_only) {
  Mesh mesh = tetrahedron();
  std::swap(mesh.indices.own()[1], mesh.indices.own()[2]);
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, 0u);
  EXPECT_EQ(edges_of(mesh, kAll).unbalanced, 3u);
}

TEST(OpenEdges, of_a_triangle_that_is_not_finite_are_its_neighbours) {
  Mesh mesh = tetrahedron();
  mesh.positions.own()[4].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, 3u);
}

TEST(OpenEdges, of_two_meshes_that_share_an_edge_there_are_none) {
  // Four triangles at one edge: even, and balanced.
  Mesh mesh = tetrahedron();
  const Mesh other = tetrahedron();
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::size_t i = 0; i < other.positions.size(); ++i) {
    const Vec3f& p = other.positions[i];
    mesh.positions.own().push_back({-p.x, -p.y, p.z});
    mesh.indices.own().push_back(count + other.indices[i]);
  }
  mesh.primitives.push_back({4, 4, 2, 0});
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, 0u);
  EXPECT_EQ(edges_of(mesh, kAll).unbalanced, 0u);
  mesh.primitives.back().triangle_count = 3;
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, 3u);
}

TEST(OpenEdges, are_known_once_somebody_had_the_time) {
  const Mesh mesh = tetrahedron();
  KnownEdges known(1);
  CancelFlag gone;
  gone.cancel();
  const Deadline cancelled{Deadline::Clock::time_point::max(), &gone};
  EXPECT_EQ(known.of(0, mesh, cancelled, {}).error().code, "CANCELLED");
  std::uint64_t asked = 0;
  const ReserveBytes reserve = [&](std::uint64_t bytes) {
    asked += bytes;
    return success();
  };
  std::vector<std::thread> askers;
  askers.reserve(4);
  std::atomic<int> right{0};
  for (int i = 0; i < 4; ++i) {
    askers.emplace_back([&] {
      const auto edges = known.of(0, mesh, Deadline::never(), {});
      right += edges.ok() && edges->unpaired == 0 ? 1 : 0;
    });
  }
  for (std::thread& asker : askers) asker.join();
  EXPECT_EQ(right, 4);
  // From then on it takes neither time nor memory.
  EXPECT_TRUE(known.of(0, mesh, cancelled, reserve).ok());
  EXPECT_EQ(asked, 0u);
}

TEST(OpenEdges, of_many_triangles_around_a_point_are_its_rim) {
  // A cone without a base, its corners written anew for every face: what sorts by points has one
  // long list.
  constexpr std::uint32_t kFaces = 30000;
  Mesh mesh;
  const auto rim = [](std::uint32_t i) {
    return Vec3f{static_cast<float>(i % kFaces), 1, static_cast<float>(i % kFaces % 7)};
  };
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    for (const Vec3f& p : {Vec3f{0, 0, 0}, rim(i), rim(i + 1)}) {
      mesh.indices.own().push_back(static_cast<std::uint32_t>(mesh.positions.size()));
      mesh.positions.own().push_back(p);
    }
  }
  mesh.primitives = {{0, kFaces, 0, 0}};
  EXPECT_EQ(edges_of(mesh, kAll).unpaired, kFaces);
  EXPECT_EQ(edges_of(mesh, kAll).unbalanced, kFaces);
}

}  // namespace
}  // namespace sightline
