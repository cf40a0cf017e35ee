#pragma once
/// The project's own scenes, made from seeds: the demo that a new server shows, and the scenes of
/// tests and benchmarks that use no file. They are written as GLB, so that they are loaded as a
/// user's scene is.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/affine.h"

namespace sightline::demo {

/// A mesh to be written: 3 floats per position, 3 indices per triangle.
struct DemoMesh {
  std::string name;
  std::string material;  ///< name of its material; meshes with equal names share the material
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  // 3, 2 and 4 floats for each vertex; an empty vector leaves the attribute out.
  std::vector<float> normals{}, uvs{}, colours{};
};

/// A node to be written.
struct DemoNode {
  std::string name;
  int parent = -1;  ///< index of an earlier node, or -1
  int mesh = -1;    ///< index in DemoScene::meshes, or -1
  Affine parent_from_node;
};

/// A scene to be written.
struct DemoScene {
  std::string name;
  std::vector<DemoMesh> meshes;
  std::vector<DemoNode> nodes;
};

/// Returns the scene as a GLB file: 16-bit indices where they fit, matrices only where they are not
/// the identity. Preconditions: parents precede their children, every mesh has triangles, the file
/// is below 4 GiB.
std::vector<std::byte> write_glb(const DemoScene& scene);

// All generators use integer arithmetic and float64 + - * / sqrt, which are correctly rounded, and
// no other libm function. So a seed gives the same bytes on every machine and with every compiler.

/// A small town on terrain with instanced trees: 52,078 unique and 362,254 placed triangles, named
/// "house 3", "roof of house 3", "tree 17" (mesh "tree", material "leaves"), "clock tower", ...
/// Metres, y up, 800 m wide. Two rays that are easy to check:
///   origin (-40,12,1) direction (1,0,0): wall of "clock tower" (mesh "tower") at t = 37
///   origin (0,100,0) direction (0,-1,0): the very tip of "spire", shared by 4 triangles, at t = 68
DemoScene town(std::uint64_t seed = 1);

/// The six-triangle hierarchy of the project's lecture notes: a root with two subtrees of three
/// triangles. Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with
/// x = -6 + 2i, of "right" with x = 2 + 2i. The four branches:
///   both   origin (-10,1,0)  direction (1,0,0):  left's triangle 0 at t = 4.5 is the closer one
///   left   origin (-5,10,0)  direction (0,-1,0): left's triangle 0 at t = 8
///   right  origin (3,10,0)   direction (0,-1,0): right's triangle 0 at t = 8
///   none   origin (1,10,0)   direction (0,-1,0): between the two
DemoScene six_triangles();

/// A square from (-1,-1,0) to (1,1,0) in two triangles, with vertex attributes. Normals lean
/// outwards by 0.6 on the left and the right. uv goes from (0,1) at the lower left to (1,0) at the
/// upper right. Colours, counter-clockwise from the lower left: red, green, blue, white. For
/// example, the ray with origin (0.5,-0.5,5) and direction (0,0,-1) gives uv (0.75,0.75) and colour
/// (0.25,0.5,0.25,1) at t = 5.
DemoScene painted_square();

// The scenes of the benchmarks: one mesh and one node each, except instances.

/// A fractal height field over 1000 x 1000, of 2 n^2 triangles for the n that is nearest to
/// `triangles`.
DemoScene terrain(std::uint32_t triangles, std::uint64_t seed = 1);
/// Random triangles with edges of about 1 in a cube of side 100, exactly `triangles` of them.
DemoScene soup(std::uint32_t triangles, std::uint64_t seed = 1);
/// Buildings, boxes, strips, cables and poles of very different sizes; many are long and thin, and
/// many touch or intersect. `triangles` or one less.
DemoScene city(std::uint32_t triangles, std::uint64_t seed = 1);
/// A closed ball of radius 1 around the origin, of 12 n^2 triangles for the n that is nearest to
/// `triangles`.
DemoScene sphere(std::uint32_t triangles, std::uint64_t seed = 1);
/// `copies` placements of one sphere of `triangles_each` triangles, on a jittered grid of pitch 3,
/// each rotated and scaled by 0.5 to 1.5 per axis.
DemoScene instances(std::uint32_t copies, std::uint32_t triangles_each, std::uint64_t seed = 1);

}  // namespace sightline::demo

// Tests: tests/unit/demo/scenes_test.cpp
