#include <utility>

#include "core/demo/demo.h"

namespace sightline::demo {

DemoScene painted_square() {
  DemoMesh mesh;
  mesh.name = "square";
  mesh.material = "paint";
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  constexpr float kLeaning = 0.6f, kUpright = 0.8f;
  mesh.normals = {-kLeaning, 0, kUpright, kLeaning,  0, kUpright,
                  kLeaning,  0, kUpright, -kLeaning, 0, kUpright};
  mesh.uvs = {0, 1, 1, 1, 1, 0, 0, 0};
  mesh.colours = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 1};
  DemoScene scene;
  scene.name = "painted square";
  scene.meshes = {std::move(mesh)};
  scene.nodes = {{"square", -1, 0, {}}};
  return scene;
}

}  // namespace sightline::demo
