#include "core/bvh/scene_tree.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/bvh/collapse.h"
#include "core/bvh/joining.h"
#include "core/bvh/reinsert.h"
#include "core/bvh/triangle_tree.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

/// u = 2^-53, half the distance from 1 to the next float64.
constexpr double kU = 0x1p-53;

struct MeshFacts {
  bool finite = true;             ///< every position is
  double largest[3] = {0, 0, 0};  ///< |coordinate| of finite positions, per axis
  std::uint32_t uses = 0;
  std::vector<std::uint32_t> corners;  ///< positions that triangles use, each once
};

MeshFacts facts_of(const MeshView& mesh) {
  MeshFacts facts;
  for (const Vec3f& p : mesh.positions) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      facts.finite = false;
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      facts.largest[k] = std::max(facts.largest[k], std::abs(static_cast<double>(p[k])));
    }
  }
  std::vector<bool> used(mesh.positions.size());
  for (const std::uint32_t index : mesh.indices) used[index] = true;
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    if (used[i]) facts.corners.push_back(i);
  }
  return facts;
}

/// World bounds of the triangles whose three corners are finite in the world.
Box3d world_bounds(const MeshView& mesh, const MeshFacts& facts, const Affine& matrix) {
  Box3d bounds;
  bool finite = facts.finite;
  for (const std::uint32_t i : facts.corners) {
    const Vec3d p = matrix.apply(mesh.positions[i]);
    finite = finite && is_finite(p);
    bounds.include(p);
  }
  if (finite) return bounds;
  // Rare: only the corners of triangles that are finite as a whole count.
  bounds = {};
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Vec3d a = matrix.apply(mesh.positions[mesh.indices[i]]);
    const Vec3d b = matrix.apply(mesh.positions[mesh.indices[i + 1]]);
    const Vec3d c = matrix.apply(mesh.positions[mesh.indices[i + 2]]);
    if (!is_finite(Triangle{a, b, c})) continue;
    bounds.include(a);
    bounds.include(b);
    bounds.include(c);
  }
  return bounds;
}

/// Fills `inverse` by cofactors; false if the matrix is singular or its inverse not finite. How
/// good the inverse is does not matter for truth: `map_space` measures it.
bool invert(const Affine& matrix, double (&inverse)[3][3]) {
  const auto& m = matrix.m;
  double cofactor[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      cofactor[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  }
  const double determinant =
      m[0][0] * cofactor[0][0] + m[0][1] * cofactor[0][1] + m[0][2] * cofactor[0][2];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      inverse[i][j] = cofactor[j][i] / determinant;
      if (!std::isfinite(inverse[i][j])) return false;
    }
  }
  return true;
}

/// How rays get into mesh space, with every error bounded (docs/exactness.md, "Instances"); false
/// if the boxes would have to grow by more than a 2^-24th of the mesh.
bool map_space(const Affine& matrix, const MeshFacts& facts, const Box3d& bounds,
               TreeSpace& space) {
  if (!invert(matrix, space.inverse)) return false;
  const auto& m = matrix.m;
  const auto& n = space.inverse;
  double world_error[3];  // of a computed world position against the exact M v + m3
  for (int j = 0; j < 3; ++j) {
    space.translation[j] = m[j][3];
    space.reach[j] = std::max(std::abs(bounds.min[j]), std::abs(bounds.max[j])) + std::abs(m[j][3]);
    double magnitude = std::abs(m[j][3]);
    for (int k = 0; k < 3; ++k) magnitude += std::abs(m[j][k]) * facts.largest[k];
    world_error[j] = 6 * kU * magnitude + 0x1p-1070;
  }
  const double extent = std::max({facts.largest[0], facts.largest[1], facts.largest[2]});
  for (int k = 0; k < 3; ++k) {
    double pad = 0;
    for (int j = 0; j < 3; ++j) {
      // Row k of N M - I: as computed, plus what computing it may have cost.
      const double product = n[k][0] * m[0][j] + n[k][1] * m[1][j] + n[k][2] * m[2][j];
      const double magnitude = std::abs(n[k][0] * m[0][j]) + std::abs(n[k][1] * m[1][j]) +
                               std::abs(n[k][2] * m[2][j]) + 1;
      const double residual = std::abs(product - (k == j ? 1 : 0)) + 6 * kU * magnitude;
      pad += residual * facts.largest[j] + std::abs(n[k][j]) * world_error[j];
    }
    space.pad[k] = pad * (1 + 16 * kU);
    if (!(space.pad[k] <= 0x1p-24 * extent)) return false;
  }
  return true;
}

void bound_edges(const Affine& matrix, const MeshFacts& facts, Placement& placement) {
  if (placement.identity) return;
  placement.edge_scale = 0;
  placement.edge_pad = 0;
  for (const auto& row : matrix.m) {
    const double scale = std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]);
    const double magnitude = std::abs(row[0]) * facts.largest[0] +
                             std::abs(row[1]) * facts.largest[1] +
                             std::abs(row[2]) * facts.largest[2] + std::abs(row[3]);
    placement.edge_scale = std::max(placement.edge_scale, scale * (1 + 16 * kU));
    placement.edge_pad = std::max(placement.edge_pad, 16 * kU * magnitude);
  }
}

/// Over the world bounds of what is entered, in units in which float32 keeps its precision.
WideTree build_top(std::span<const Box3d> bounds, const Box3d& all, TreeQuality quality) {
  const int scale_exponent = choose_scale_exponent(all);
  const double scale = std::ldexp(1.0, scale_exponent);
  Column<BuildBox> boxes(bounds.size());
  for (std::uint32_t i = 0; i < bounds.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      boxes[i].lower[k] = float_below(bounds[i].min[k] * scale);
      boxes[i].upper[k] = float_above(bounds[i].max[k] * scale);
    }
    boxes[i].id = i;
  }
  // Entering a placement is dear: leaves of one.
  BinaryOptions options;
  options.block_size = {0};
  options.leaf_max = 1;
  CollapseOptions costs;
  costs.block = 1;
  costs.leaf_max = 1;
  BinaryTree binary = build_binary_tree(std::move(boxes), options);
  if (quality == TreeQuality::kHigh) reinsert(binary, {});
  WideTree top =
      collapse(binary, costs, [&](std::uint32_t first, std::uint32_t count, LeafBlock* block) {
        for (std::uint32_t i = 0; i < kLanes; ++i)
          block->triangle[i] = binary.ids[first + (i < count ? i : 0)];
        block->lane_count = count;
      });
  top.scale_exponent = scale_exponent;
  top.bounds = all;
  return top;
}

Placement make_placement(std::uint32_t instance, const PlacementView& view,
                         const MeshFacts& facts) {
  Placement placement;
  placement.instance = instance;
  placement.world_from_mesh = view.world_from_mesh;
  placement.identity = view.world_from_mesh.is_identity();
  bound_edges(view.world_from_mesh, facts, placement);
  return placement;
}

/// Puts the placements together into one tree of the world, the last entry.
void add_joined(std::span<const MeshView> meshes, std::span<const PlacementView> placements,
                std::span<const MeshFacts> facts, std::span<const std::uint32_t> joined,
                TreeQuality quality, SceneTree& scene) {
  std::vector<TreePart> parts;
  std::vector<Placement> behind;
  bool identity = true;
  for (const std::uint32_t i : joined) {
    const PlacementView& view = placements[i];
    behind.push_back(make_placement(i, view, facts[view.mesh]));
    behind.back().tree = static_cast<std::uint32_t>(scene.trees.size());
    identity = identity && behind.back().identity;
    parts.push_back({meshes[view.mesh], behind.back().identity ? nullptr : &view.world_from_mesh});
  }
  auto tree = std::make_unique<WideTree>(build_triangle_tree(parts, quality));
  if (tree->root == ChildRef::kEmpty) return;
  for (Placement& placement : behind) placement.identity = identity;
  scene.trees.push_back(std::move(tree));
  scene.placements.insert(scene.placements.end(), behind.begin(), behind.end());
  ++scene.entries;
}

}  // namespace

Result<SceneTree> build_scene_tree(std::span<const MeshView> meshes,
                                   std::span<const PlacementView> placements, TreeQuality quality,
                                   Joining joining) {
  SceneTree scene;
  std::vector<MeshFacts> facts;
  for (const MeshView& mesh : meshes) {
    if (mesh.triangle_count() > kMaxTriangles) {
      return Error{ErrorKind::kTooLarge, "SCENE_TOO_LARGE",
                   "a mesh has " + std::to_string(mesh.triangle_count()) +
                       " triangles, a tree holds at most " + std::to_string(kMaxTriangles),
                   ""};
    }
    facts.push_back(facts_of(mesh));
  }
  for (const PlacementView& placement : placements) ++facts[placement.mesh].uses;
  std::vector<Box3d> placed(placements.size());
  parallel_for(placements.size(), [&](std::size_t i) {
    const PlacementView& view = placements[i];
    placed[i] = world_bounds(meshes[view.mesh], facts[view.mesh], view.world_from_mesh);
  });
  const std::vector<std::uint32_t> joined = joining == Joining::kMeasured
                                                ? choose_joined(meshes, placements, placed)
                                                : std::vector<std::uint32_t>{};

  constexpr std::uint32_t kNoTree = 0xffffffffu;
  std::vector<std::uint32_t> shared(meshes.size(), kNoTree);
  std::vector<Box3d> bounds;
  Box3d joined_bounds;
  std::size_t next_joined = 0;
  for (std::uint32_t i = 0; i < placements.size(); ++i) {
    const PlacementView& view = placements[i];
    const MeshView& mesh = meshes[view.mesh];
    const MeshFacts& mesh_facts = facts[view.mesh];
    const Box3d& box = placed[i];
    if (next_joined < joined.size() && joined[next_joined] == i) {
      joined_bounds.include(box);
      ++next_joined;
      continue;
    }
    if (box.empty()) continue;

    Placement placement = make_placement(i, view, mesh_facts);
    const bool mapped = !placement.identity && mesh_facts.uses > 1 && mesh_facts.finite &&
                        map_space(view.world_from_mesh, mesh_facts, box, placement.space);
    placement.world_boxes = !mapped;
    const bool own = !placement.identity && !mapped;
    std::uint32_t& tree = shared[view.mesh];
    if (own || tree == kNoTree) {
      scene.trees.push_back(std::make_unique<WideTree>(
          build_triangle_tree(mesh, own ? &view.world_from_mesh : nullptr, quality)));
      placement.tree = static_cast<std::uint32_t>(scene.trees.size() - 1);
      if (!own) tree = placement.tree;
    } else {
      placement.tree = tree;
    }
    if (scene.trees[placement.tree]->root == ChildRef::kEmpty) continue;
    scene.placements.push_back(placement);
    ++scene.entries;
    bounds.push_back(box);
    scene.bounds.include(box);
  }
  if (!joined.empty()) {
    const std::uint32_t before = scene.entries;
    add_joined(meshes, placements, facts, joined, quality, scene);
    if (scene.entries > before) {
      bounds.push_back(joined_bounds);
      scene.bounds.include(joined_bounds);
    }
  }
  if (scene.entries > 1) scene.top = build_top(bounds, scene.bounds, quality);
  std::uint32_t deepest = 0;
  for (const auto& tree : scene.trees) deepest = std::max(deepest, tree->depth);
  scene.depth = scene.top.depth + deepest;
  return scene;
}

}  // namespace sightline
