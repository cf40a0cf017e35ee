#include "core/trace/search/box_region.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/rounding.h"
#include "core/trace/bounds.h"

namespace sightline {

namespace {

using bounds::kScaledUnderflow;
using bounds::kUnderflow;

using Matrix = std::array<std::array<double, 3>, 3>;

/// An oriented box as a centre and three spanning vectors: every point of it is within `error` of
/// some center + sum s_m span_m, |s_m| <= half_m, on each axis.
struct Spanned {
  std::array<double, 3> center{};
  Matrix span{};  ///< [axis of the world][axis of the box]
  std::array<double, 3> half{};
  std::array<double, 3> error{};
};

/// 0 times an open side is nothing; everything else of an open side is open.
double reach_of(double factor, double half) { return factor == 0 ? 0 : factor * half; }

/// The columns of the inverse of the axes, by cofactors. How good it is does not matter for truth:
/// the residual is measured and goes into `error`.
Spanned spanned(const OrientedBox& box) {
  Spanned s;
  s.center = {box.center.x, box.center.y, box.center.z};
  s.half = {box.half.x, box.half.y, box.half.z};
  const auto axis = [&](std::size_t k, std::size_t i) { return box.axes[k][static_cast<int>(i)]; };
  double determinant = 0;
  Matrix cofactor{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k1 = (k + 1) % 3, k2 = (k + 2) % 3, i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      cofactor[k][i] = axis(k1, i1) * axis(k2, i2) - axis(k1, i2) * axis(k2, i1);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) determinant += axis(0, i) * cofactor[0][i];
  // y = p - c, s = A y, B near the inverse of A. Then y = B s + (I - B A) y, so that |y| <= |B| h +
  // r |y| with r the largest row sum of |I - B A|.
  double residual = 0;
  bool finite = true;
  for (std::size_t i = 0; i < 3; ++i) {
    double row = 0;
    for (std::size_t k = 0; k < 3; ++k) s.span[i][k] = cofactor[k][i] / determinant;
    for (std::size_t j = 0; j < 3; ++j) {
      double product = i == j ? -1 : 0, magnitude = 1;
      for (std::size_t k = 0; k < 3; ++k) {
        product += s.span[i][k] * axis(k, j);
        magnitude += std::abs(s.span[i][k] * axis(k, j));
      }
      row += std::abs(product) + 8 * kU * magnitude + kUnderflow;
    }
    finite = finite && std::isfinite(row);
    residual = std::max(residual, row);
  }
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += reach_of(std::abs(s.span[i][k]), s.half[k]);
    largest = std::max(largest, sum);
  }
  const double error = finite && residual < 0.5 ? 4 * residual * largest + kUnderflow : kInfD;
  s.error = {error, error, error};
  return s;
}

/// Sets one axis to the outward float32 bounds of a range in scene or mesh units.
void set_axis(const WideTree& tree, std::size_t k, double low, double high, TreeRegion& region) {
  const double scale = std::ldexp(1.0, tree.scale_exponent);
  const double pad = tree.scale_exponent == 0 ? 0 : kScaledUnderflow;
  // What could not be computed excludes nothing.
  region.lower[k] = std::isnan(low) ? -kInfF : float_below(low * scale - pad);
  region.upper[k] = std::isnan(high) ? kInfF : float_above(high * scale + pad);
}

TreeRegion region_of(const WideTree& tree, const Box3d& box) {
  TreeRegion region;
  for (int k = 0; k < 3; ++k) {
    set_axis(tree, static_cast<std::size_t>(k), box.min[k], box.max[k], region);
  }
  return region;
}

/// Adds |a . (x - c)| <= h. Only for trees in scene units, where nothing underflows that matters.
void add_slab(const WideTree& tree, const Vec3d& axis, const Vec3d& center, double half,
              TreeRegion& region) {
  TreeRegion::Slab slab;
  double middle = 0, magnitude = half, reach = 0;
  for (int k = 0; k < 3; ++k) {
    slab.normal[static_cast<std::size_t>(k)] = axis[k];
    middle += axis[k] * center[k];
    magnitude += std::abs(axis[k] * center[k]);
    // Boxes of the tree are rounded outwards to float32.
    const double largest = std::max(std::abs(tree.bounds.min[k]), std::abs(tree.bounds.max[k]));
    reach += std::abs(axis[k]) * (largest * (1 + 0x1p-20) + 0x1p-140);
  }
  const double margin = 8 * kU * (magnitude + reach) + kUnderflow;
  slab.low = middle - half - margin;
  slab.high = middle + half + margin;
  if (!std::isfinite(slab.low) || !std::isfinite(slab.high) || !std::isfinite(reach)) return;
  region.slabs[static_cast<std::size_t>(region.slab_count++)] = slab;
}

/// Everything in the tree.
TreeRegion whole_region() {
  TreeRegion region;
  region.lower = {-kInfF, -kInfF, -kInfF};
  region.upper = {kInfF, kInfF, kInfF};
  return region;
}

/// Adds a plane of the world to the region of a tree in mesh units. The corners of the world are
/// those of the mesh, moved by `world`, so that a plane moves the other way.
void add_half_space(const WideTree& tree, const Affine& world, const HalfSpace& plane,
                    TreeRegion& region) {
  if (region.slab_count == TreeRegion::kMostSlabs) return;
  TreeRegion::Slab slab;
  double fixed = 0, magnitude = std::abs(plane.offset);
  for (std::size_t k = 0; k < 3; ++k) {
    const double n = plane.normal[static_cast<int>(k)];
    fixed += n * world.m[k][3];
    magnitude += std::abs(n) * (std::abs(world.m[k][3]) + 0x1p-140);
    for (std::size_t j = 0; j < 3; ++j) {
      slab.normal[j] += n * world.m[k][j];
      const int axis = static_cast<int>(j);
      // Boxes of the tree are rounded outwards to float32.
      const double largest =
          std::max(std::abs(tree.bounds.min[axis]), std::abs(tree.bounds.max[axis]));
      magnitude +=
          std::abs(n) * (std::abs(world.m[k][j]) + 0x1p-140) * (largest * (1 + 0x1p-20) + 0x1p-140);
    }
  }
  const double margin = 32 * kU * magnitude + kUnderflow;
  slab.low = -kInfD;
  slab.high = (plane.offset - fixed) + margin;
  if (!std::isfinite(slab.high)) return;
  region.slabs[static_cast<std::size_t>(region.slab_count++)] = slab;
}

}  // namespace

Box3d outer_bounds(const OrientedBox& box) {
  const Spanned s = spanned(box);
  Box3d bounds;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    double reach = s.error[i];
    for (std::size_t m = 0; m < 3; ++m) reach += reach_of(std::abs(s.span[i][m]), s.half[m]);
    reach = reach * (1 + 16 * kU) + 4 * kU * std::abs(s.center[i]) + kUnderflow;
    const double low = s.center[i] - reach, high = s.center[i] + reach;
    bounds.min[k] = std::isnan(low) ? -kInfD : low;
    bounds.max[k] = std::isnan(high) ? kInfD : high;
  }
  return bounds;
}

TreeRegion world_region(const WideTree& tree, const Box3d& box) { return region_of(tree, box); }

TreeRegion world_region(const WideTree& tree, const OrientedBox& box) {
  TreeRegion region = region_of(tree, outer_bounds(box));
  if (tree.scale_exponent != 0) return region;
  for (std::size_t k = 0; k < 3; ++k) {
    add_slab(tree, box.axes[k], box.center, box.half[static_cast<int>(k)], region);
  }
  return region;
}

TreeRegion world_region(const WideTree& tree, const ConvexRegion& region) {
  TreeRegion result = whole_region();
  if (tree.scale_exponent != 0) return result;
  for (const HalfSpace& plane : region.planes) add_half_space(tree, Affine{}, plane, result);
  return result;
}

TreeRegion region_in(const WideTree& tree, const Placement& placement, const ConvexRegion& region) {
  if (placement.world_boxes) return world_region(tree, region);
  TreeRegion result = whole_region();
  if (tree.scale_exponent != 0) return result;
  for (const HalfSpace& plane : region.planes) {
    add_half_space(tree, placement.world_from_mesh, plane, result);
  }
  return result;
}

TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space, const Box3d& box) {
  TreeRegion region;
  for (std::size_t k = 0; k < 3; ++k) {
    double low = 0, high = 0, error = space.pad[k] + kUnderflow;
    for (int j = 0; j < 3; ++j) {
      const double n = space.inverse[k][j];
      if (n == 0) continue;
      const double from_min = n * (box.min[j] - space.translation[j]);
      const double from_max = n * (box.max[j] - space.translation[j]);
      low += std::min(from_min, from_max);
      high += std::max(from_min, from_max);
      // An open side needs no margin, and must not make that of the other one infinite.
      for (const double side : {box.min[j], box.max[j]}) {
        if (std::isfinite(side)) {
          error += 12 * kU * std::abs(n) * (std::abs(side) + std::abs(space.translation[j]));
        }
      }
    }
    set_axis(tree, k, low - error, high + error, region);
  }
  return region;
}

TreeRegion mapped_region(const WideTree& tree, const TreeSpace& space, const OrientedBox& box) {
  const Spanned s = spanned(box);
  TreeRegion region;
  for (std::size_t k = 0; k < 3; ++k) {
    double center = 0, reach = space.pad[k] + kUnderflow;
    for (std::size_t j = 0; j < 3; ++j) {
      const double n = space.inverse[k][j];
      if (n == 0) continue;
      center += n * (s.center[j] - space.translation[j]);
      reach += std::abs(n) * s.error[j] +
               12 * kU * std::abs(n) * (std::abs(s.center[j]) + std::abs(space.translation[j]));
    }
    for (std::size_t m = 0; m < 3; ++m) {
      double factor = 0, magnitude = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        const double n = space.inverse[k][j], span = s.span[j][m];
        factor += n * span;
        // What a product loses by underflow counts: a half extent may be as large as 2^1024.
        magnitude += std::abs(n * span) + (n == 0 || span == 0 ? 0 : 0x1p-1020);
      }
      reach += reach_of(std::abs(factor) + 8 * kU * magnitude, s.half[m]);
    }
    reach *= 1 + 32 * kU;
    set_axis(tree, k, center - reach, center + reach, region);
  }
  return region;
}

unsigned overlapped_children(const WideNode& node, const TreeRegion& region) {
  std::array<unsigned char, kArity> outside{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < kArity; ++i) {
      outside[i] = static_cast<unsigned char>(outside[i] | (node.lower[k][i] > region.upper[k]) |
                                              (node.upper[k][i] < region.lower[k]));
    }
  }
  unsigned mask = 0;
  for (std::size_t i = 0; i < kArity; ++i) {
    // An empty child is not outside of an open region.
    if (outside[i] == 0 && node.child[i] != ChildRef::kEmpty) mask |= 1u << i;
  }
  for (int s = 0; s < region.slab_count; ++s) {
    const TreeRegion::Slab& slab = region.slabs[static_cast<std::size_t>(s)];
    for (std::size_t i = 0; i < kArity; ++i) {
      if ((mask & (1u << i)) == 0) continue;
      double low = 0, high = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double a = slab.normal[k] * static_cast<double>(node.lower[k][i]);
        const double b = slab.normal[k] * static_cast<double>(node.upper[k][i]);
        low += a < b ? a : b;
        high += a < b ? b : a;
      }
      if (low > slab.high || high < slab.low) mask &= ~(1u << i);
    }
  }
  return mask;
}

}  // namespace sightline
