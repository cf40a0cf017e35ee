#pragma once
/// Small meshes with float32 corners, and scenes made of them.

#include <memory>
#include <string>
#include <vector>

#include "tests/stress/case.h"

namespace sightline::stress {

/// Corners and triangles under construction.
class MeshMaker {
 public:
  std::uint32_t corner(double x, double y, double z);
  std::uint32_t corner(const Vec3d& p) { return corner(p.x, p.y, p.z); }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Three new corners.
  void triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c);
  /// The 12 triangles of a box with shared corners.
  void box(const Vec3d& min, const Vec3d& max);
  /// A closed ball of 2 * columns * (rows - 1) triangles with shared corners; radii vary by +-bump.
  void ball(Random& random, const Vec3d& center, double radius, int rows, int columns, double bump);
  std::shared_ptr<const Mesh> finish();

 private:
  Mesh mesh_;
};

using MeshPointer = std::shared_ptr<const Mesh>;

SceneDescription scene_of(std::vector<MeshPointer> meshes, const std::vector<Affine>& placements);
/// One mesh placed once, where it is.
SceneDescription scene_of(MeshPointer mesh);
void place(SceneDescription& scene, std::uint32_t mesh, const Affine& world_from_mesh);

Affine translation(double x, double y, double z);
Affine scaling(double x, double y, double z);
/// Any rotation, in rounded numbers.
Affine rotation(Random& random);

/// The float64 triangles of the whole scene, in the order of their ids.
std::vector<Triangle> world(const SceneDescription& scene);

/// A closed bumpy ball of about `triangles` triangles: "the scan".
MeshPointer scan(Random& random, int triangles);
/// n^3 unit cubes that share faces with their neighbours, each with its own corners and triangles.
MeshPointer stacked_cubes(int n);
/// `count` triangles with edges of about 1 in a cube of side `side`.
MeshPointer soup(Random& random, int count, double side);

}  // namespace sightline::stress
