#include "core/demo/shapes.h"

#include <cmath>
#include <map>
#include <tuple>

namespace sightline::demo {

std::uint32_t add_vertex(DemoMesh& mesh, double x, double y, double z) {
  const auto index = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (double value : {x, y, z}) mesh.positions.push_back(static_cast<float>(value));
  return index;
}

void add_triangle(DemoMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

void add_quad(DemoMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  add_triangle(mesh, a, b, c);
  add_triangle(mesh, a, c, d);
}

void add_box(DemoMesh& mesh, const Vec3d& min, const Vec3d& max) {
  const auto v = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (int i = 0; i < 8; ++i) {
    add_vertex(mesh, (i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y,
               (i & 4) != 0 ? max.z : min.z);
  }
  add_quad(mesh, v + 0, v + 4, v + 6, v + 2);  // -x
  add_quad(mesh, v + 1, v + 3, v + 7, v + 5);  // +x
  add_quad(mesh, v + 0, v + 1, v + 5, v + 4);  // -y
  add_quad(mesh, v + 2, v + 6, v + 7, v + 3);  // +y
  add_quad(mesh, v + 0, v + 2, v + 3, v + 1);  // -z
  add_quad(mesh, v + 4, v + 5, v + 7, v + 6);  // +z
}

void add_column(DemoMesh& mesh, const UprightColumn& column) {
  // The corners of a square and of an octagon, counter-clockwise seen from above (+y towards the
  // eye, z down the page).
  const double h = std::sqrt(0.5);
  const double corner[8][2] = {{1, 0},  {h, -h}, {0, -1}, {-h, -h},
                               {-1, 0}, {-h, h}, {0, 1},  {h, h}};
  const std::size_t step = column.sides == 4 ? 2 : 1, count = column.sides == 4 ? 4 : 8;
  const auto ring = [&](double y, double radius) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
    for (std::size_t i = 0; i < count; ++i) {
      add_vertex(mesh, column.x + radius * corner[i * step][0], y,
                 column.z + radius * corner[i * step][1]);
    }
    return first;
  };
  const auto n = static_cast<std::uint32_t>(count);
  const std::uint32_t low = ring(column.bottom, column.bottom_radius);
  if (column.top_radius > 0) {
    const std::uint32_t high = ring(column.top, column.top_radius);
    for (std::uint32_t i = 0; i < n; ++i) {
      add_quad(mesh, low + i, low + (i + 1) % n, high + (i + 1) % n, high + i);
    }
    for (std::uint32_t i = 2; i < n; ++i) add_triangle(mesh, high, high + i - 1, high + i);
  } else {
    const std::uint32_t apex = add_vertex(mesh, column.x, column.top, column.z);
    for (std::uint32_t i = 0; i < n; ++i) add_triangle(mesh, low + i, low + (i + 1) % n, apex);
  }
  for (std::uint32_t i = 2; i < n; ++i) add_triangle(mesh, low, low + i, low + i - 1);
}

void add_tube(DemoMesh& mesh, const Vec3d* points, int count, double radius) {
  const double offset[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  const Vec3d& a = points[0];
  const Vec3d& b = points[count - 1];
  // Sideways: horizontal and across the run, so that the tube never closes up.
  double sx = -(b.z - a.z), sz = b.x - a.x;
  const double length = std::sqrt(sx * sx + sz * sz);
  if (length > 0) {
    sx /= length;
    sz /= length;
  } else {
    sx = 1;
  }
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (int i = 0; i < count; ++i) {
    for (const auto& o : offset) {
      add_vertex(mesh, points[i].x + radius * o[0] * sx, points[i].y + radius * o[1],
                 points[i].z + radius * o[0] * sz);
    }
  }
  for (std::uint32_t i = 0; i + 1 < static_cast<std::uint32_t>(count); ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t p = first + i * 4 + k, q = first + i * 4 + (k + 1) % 4;
      add_quad(mesh, p, q, q + 4, p + 4);
    }
  }
}

void add_ball(DemoMesh& mesh, const Vec3d& centre, double radius, int cells) {
  // Vertices on the cube's edges are shared, so that the ball is closed as a graph, too.
  std::map<std::tuple<int, int, int>, std::uint32_t> vertices;
  const auto vertex = [&](int i, int j, int k) {
    const auto [it, fresh] = vertices.try_emplace({i, j, k}, 0u);
    if (fresh) {
      const double x = 2.0 * i / cells - 1, y = 2.0 * j / cells - 1, z = 2.0 * k / cells - 1;
      const double xx = x * x, yy = y * y, zz = z * z;
      it->second =
          add_vertex(mesh, centre.x + radius * (x * std::sqrt(1 - yy / 2 - zz / 2 + yy * zz / 3)),
                     centre.y + radius * (y * std::sqrt(1 - zz / 2 - xx / 2 + zz * xx / 3)),
                     centre.z + radius * (z * std::sqrt(1 - xx / 2 - yy / 2 + xx * yy / 3)));
    }
    return it->second;
  };
  // Face `axis` low and high: (u, v) are the next two axes, so that the outside is in front.
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      for (int u = 0; u < cells; ++u) {
        for (int v = 0; v < cells; ++v) {
          const auto at = [&](int du, int dv) {
            int p[3] = {0, 0, 0};
            p[axis] = side == 0 ? 0 : cells;
            p[(axis + 1) % 3] = u + du;
            p[(axis + 2) % 3] = v + dv;
            return vertex(p[0], p[1], p[2]);
          };
          const std::uint32_t a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
          if (side == 1) {
            add_quad(mesh, a, b, c, d);
          } else {
            add_quad(mesh, a, d, c, b);
          }
        }
      }
    }
  }
}

}  // namespace sightline::demo
