#include "core/demo/demo.h"
#include "core/demo/shapes.h"

namespace sightline::demo {

namespace {

DemoMesh three_triangles(const char* name, double first_x) {
  DemoMesh mesh;
  mesh.name = name;
  mesh.material = name;
  for (int i = 0; i < 3; ++i) {
    const double x = first_x + 2 * i;
    const std::uint32_t a = add_vertex(mesh, x, 0, 2), b = add_vertex(mesh, x, 0, -2),
                        c = add_vertex(mesh, x + 2, 4, 0);
    add_triangle(mesh, a, c, b);
  }
  return mesh;
}

}  // namespace

DemoScene six_triangles() {
  DemoScene scene;
  scene.name = "six triangles";
  scene.meshes = {three_triangles("left", -6), three_triangles("right", 2)};
  scene.nodes = {{"root", -1, -1, {}}, {"left", 0, 0, {}}, {"right", 0, 1, {}}};
  return scene;
}

}  // namespace sightline::demo
