#include "core/bvh/placing.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/rounding.h"

namespace sightline {

namespace {

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

void bound_edges(const Affine& matrix, const MeshFacts& facts, Placement& placement) {
  if (placement.identity) return;
  placement.edge_scale = 0;
  placement.edge_pad = 0;
  for (const auto& row : matrix.m) {
    const double scale = std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]);
    const double magnitude = std::abs(row[0]) * facts.largest(0) +
                             std::abs(row[1]) * facts.largest(1) +
                             std::abs(row[2]) * facts.largest(2) + std::abs(row[3]);
    placement.edge_scale = std::max(placement.edge_scale, scale * (1 + 16 * kU));
    placement.edge_pad = std::max(placement.edge_pad, 16 * kU * magnitude);
  }
}

/// False if the boxes would have to grow by more than a 2^-24th of the mesh.
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
    for (int k = 0; k < 3; ++k) magnitude += std::abs(m[j][k]) * facts.largest(k);
    world_error[j] = 6 * kU * magnitude + 0x1p-1070;
  }
  const double extent = std::max({facts.largest(0), facts.largest(1), facts.largest(2)});
  for (int k = 0; k < 3; ++k) {
    double pad = 0;
    for (int j = 0; j < 3; ++j) {
      // Row k of N M - I: as computed, plus what computing it may have cost.
      const double product = n[k][0] * m[0][j] + n[k][1] * m[1][j] + n[k][2] * m[2][j];
      const double magnitude = std::abs(n[k][0] * m[0][j]) + std::abs(n[k][1] * m[1][j]) +
                               std::abs(n[k][2] * m[2][j]) + 1;
      const double residual = std::abs(product - (k == j ? 1 : 0)) + 6 * kU * magnitude;
      pad += residual * facts.largest(j) + std::abs(n[k][j]) * world_error[j];
    }
    space.pad[k] = pad * (1 + 16 * kU);
    if (!(space.pad[k] <= 0x1p-24 * extent)) return false;
  }
  return true;
}

}  // namespace

Placement make_placement(std::uint32_t instance, const PlacementView& view,
                         const MeshFacts& facts) {
  Placement placement;
  placement.instance = instance;
  placement.world_from_mesh = view.world_from_mesh;
  placement.identity = view.world_from_mesh.is_identity();
  placement.diagonal = view.world_from_mesh.is_diagonal();
  bound_edges(view.world_from_mesh, facts, placement);
  return placement;
}

Placement place_alone(const ScenePlan& plan, std::uint32_t i, bool moves) {
  const PlacementView& view = plan.placements[i];
  const MeshFacts& facts = plan.facts[view.mesh];
  Placement placement = make_placement(i, view, facts);
  placement.world_boxes = placement.identity || (facts.uses < 2 && !moves) || !facts.finite ||
                          !map_space(view.world_from_mesh, facts, plan.placed[i], placement.space);
  return placement;
}

}  // namespace sightline
