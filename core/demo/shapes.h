#pragma once
/// Solids that the generators append to a mesh. Triangles run counter-clockwise seen from outside.

#include "core/demo/demo.h"
#include "core/geometry/vec3.h"

namespace sightline::demo {

/// Appends a vertex, rounded to float32, and returns its index.
std::uint32_t add_vertex(DemoMesh& mesh, double x, double y, double z);
/// Appends a triangle of three vertices, by their indices.
void add_triangle(DemoMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c);
/// Appends two triangles, a b c and a c d, by the indices of their vertices.
void add_quad(DemoMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

/// Appends a closed axis-aligned box: 8 vertices, 12 triangles.
void add_box(DemoMesh& mesh, const Vec3d& min, const Vec3d& max);
/// An upright prism or truncated cone around the vertical line through (x, z); `sides` is 4 or 8.
struct UprightColumn {
  int sides;
  double x, z, bottom, top, bottom_radius;  ///< bottom, top: y of the ends
  double top_radius;                        ///< 0: a cone with one apex
};
/// Appends the closed column: 2 * sides vertices and 4 * sides - 4 triangles; a cone has 2 * sides
/// - 2 triangles.
void add_column(DemoMesh& mesh, const UprightColumn& column);
/// Appends a square tube through `count` points, open at its ends: 8 triangles for each piece
/// between two points.
void add_tube(DemoMesh& mesh, const Vec3d* points, int count, double radius);
/// Appends a closed ball of 12 * cells^2 triangles: the grid of a cube's surface, mapped to the
/// sphere by a formula that needs only square roots.
void add_ball(DemoMesh& mesh, const Vec3d& centre, double radius, int cells);
/// Appends a height field of cells x cells squares over [-half, half]^2: 2 * cells^2 triangles.
/// height(x, z) returns y.
template <class Height>
void add_height_field(DemoMesh& mesh, double half, std::uint32_t cells, const Height& height) {
  const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  const auto place = [&](std::uint32_t i) { return -half + 2 * half * i / cells; };
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      add_vertex(mesh, place(i), height(place(i), place(j)), place(j));
    }
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = first + j * (cells + 1) + i, b = a + cells + 1;
      add_quad(mesh, a, b, b + 1, a + 1);
    }
  }
}

}  // namespace sightline::demo

// Tests: tests/unit/demo/scenes_test.cpp
