#include "core/trace/search/box_distance.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/rounding.h"
#include "core/trace/bounds.h"

namespace sightline {

namespace {

using bounds::kScaledUnderflow;
using bounds::kUnderflow;
/// Covers the roundings of a square distance and of its bound.
constexpr double kMore = 1 + 0x1p-40;
/// More than underflow can take from any square.
constexpr double kSquareUnderflow = 0x1p-1000;

void scale(const WideTree& tree, TreePoint& point) {
  if (tree.scale_exponent == 0) return;
  const double factor = std::ldexp(1.0, tree.scale_exponent);
  for (double& x : point.at) x *= factor;
  for (double& x : point.margin) x = x * factor + kScaledUnderflow;
  point.stretch *= factor;
}

/// At least the spectral norm: the root of the largest row sum of |N N^T|.
double norm(const double (&n)[3][3]) {
  double largest = 0, square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      largest = std::max(largest, std::fabs(n[i][j]));
      double product = 0, magnitude = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        product += n[i][k] * n[j][k];
        magnitude += std::fabs(n[i][k] * n[j][k]);
      }
      sum += std::fabs(product) + 8 * kU * magnitude;
    }
    square = std::max(square, sum);
  }
  // Where squares could overflow or vanish nothing is certain.
  if (!(largest < 0x1p400) || largest < 0x1p-400) return kInfD;
  return std::sqrt(square) * kMore;
}

}  // namespace

double TreePoint::square_within(double distance) const {
  const double reach = distance * stretch;
  // Infinity times nothing: everything.
  if (std::isnan(reach)) return kInfD;
  return reach * reach * kMore + kSquareUnderflow;
}

TreePoint world_point(const WideTree& tree, const Vec3d& point) {
  TreePoint result{{point.x, point.y, point.z}, {}, 1};
  scale(tree, result);
  return result;
}

TreePoint mapped_point(const WideTree& tree, const TreeSpace& space, const Vec3d& point) {
  TreePoint result;
  for (std::size_t k = 0; k < 3; ++k) {
    double at = 0, error = space.pad[k] + kUnderflow;
    for (std::size_t j = 0; j < 3; ++j) {
      const double n = space.inverse[k][j], x = point[static_cast<int>(j)];
      if (n == 0) continue;
      at += n * (x - space.translation[j]);
      error += 12 * kU * std::fabs(n) * (std::fabs(x) + std::fabs(space.translation[j]));
    }
    result.at[k] = at;
    result.margin[k] = error;
  }
  result.stretch = norm(space.inverse);
  scale(tree, result);
  return result;
}

std::array<double, kArity> square_distances(const WideNode& node, const TreePoint& point) {
  std::array<double, kArity> square{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = point.at[k], margin = point.margin[k];
    for (std::size_t i = 0; i < kArity; ++i) {
      const double below = static_cast<double>(node.lower[k][i]) - at;
      const double above = at - static_cast<double>(node.upper[k][i]);
      const double outside = (below > above ? below : above) - margin;
      // NaN is no distance.
      const double gap = outside > 0 ? outside : 0;
      square[i] += gap * gap;
    }
  }
  return square;
}

}  // namespace sightline
