#pragma once
/// The project's own scenes, made from seeds: the demo that a fresh server shows, and what tests
/// and benchmarks trace when no file is at hand. Written as GLB, so that they take the same road as
/// a user's scene.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/affine.h"

namespace sightline::demo {

/// A triangle soup or an indexed mesh to be written: 3 floats per position, 3 indices per triangle.
struct DemoMesh {
  std::string name;
  std::string material;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
};

struct DemoNode {
  std::string name;
  int parent = -1;  ///< index of an earlier node, or -1
  int mesh = -1;    ///< index in DemoScene::meshes, or -1
  Affine parent_from_node;
};

struct DemoScene {
  std::string name;
  std::vector<DemoMesh> meshes;
  std::vector<DemoNode> nodes;
};

/// The scene as one GLB file: u16 indices where they fit, matrices only where not identity.
std::vector<std::byte> write_glb(const DemoScene& scene);

/// A small town on terrain with instanced trees: about 60,000 unique and 400,000 placed triangles.
DemoScene town(std::uint64_t seed = 1);
/// The six-triangle hierarchy of SEEDS.md, row 24: a root with two subtrees of three triangles.
DemoScene six_triangles();

/// The benchmark set (PERFORMANCE.md): terrain is a fractal height field, soup random triangles,
/// city boxes, strips, cables and poles of very different sizes; sphere is a closed dense ball,
/// used as instances(copies, triangles) on a jittered grid with rotations and scales.
DemoScene terrain(std::uint32_t triangles, std::uint64_t seed = 1);
DemoScene soup(std::uint32_t triangles, std::uint64_t seed = 1);
DemoScene city(std::uint32_t triangles, std::uint64_t seed = 1);
DemoScene sphere(std::uint32_t triangles, std::uint64_t seed = 1);
DemoScene instances(std::uint32_t copies, std::uint32_t triangles_each, std::uint64_t seed = 1);

}  // namespace sightline::demo
