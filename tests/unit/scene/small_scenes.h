#pragma once
/// Small scenes for tests of trees.

#include <gtest/gtest.h>

#include "core/demo/demo.h"
#include "core/import/import.h"
#include "core/scene/scene.h"

namespace sightline::test {

inline SceneDescription description_of(const demo::DemoScene& scene) {
  Result<SceneDescription> description = import_bytes(demo::write_glb(scene), {});
  EXPECT_TRUE(description.ok());
  return std::move(*description);
}

/// Three entries: one that joins, and two whose sizes do not fit it.
inline demo::DemoScene three_sizes() {
  demo::DemoScene scene = demo::six_triangles();
  const int mesh = scene.nodes.back().mesh;
  for (const double size : {1e30, 1e-30}) {
    demo::DemoNode node;
    node.mesh = mesh;
    for (int k = 0; k < 3; ++k) node.parent_from_node.m[k][k] = size;
    scene.nodes.push_back(node);
  }
  return scene;
}

}  // namespace sightline::test
