#include "tests/contestants/overlap_tests.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::contestants {

namespace {

/// [AkenineMoeller2001]: centre and half size, thirteen axes, `>` rejects.
template <class Real>
bool akenine_moeller2001(const Triangle& triangle, const Box3d& box) {
  using Vector = std::array<Real, 3>;
  Vector half{};
  std::array<Vector, 3> v{};
  const std::array<const Vec3d*, 3> corners{&triangle.v0, &triangle.v1, &triangle.v2};
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const Real low = static_cast<Real>(box.min[axis]);
    const Real high = static_cast<Real>(box.max[axis]);
    const Real centre = (low + high) * Real(0.5);
    half[k] = (high - low) * Real(0.5);
    for (std::size_t c = 0; c < 3; ++c) v[c][k] = static_cast<Real>((*corners[c])[axis]) - centre;
  }
  const auto separates = [&](const Vector& a) {
    const auto dot = [](const Vector& x, const Vector& y) {
      return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    };
    const Real p0 = dot(a, v[0]), p1 = dot(a, v[1]), p2 = dot(a, v[2]);
    const Real reach =
        half[0] * std::abs(a[0]) + half[1] * std::abs(a[1]) + half[2] * std::abs(a[2]);
    return std::min({p0, p1, p2}) > reach || std::max({p0, p1, p2}) < -reach;
  };
  std::array<Vector, 3> edge{};
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t k = 0; k < 3; ++k) edge[e][k] = v[(e + 1) % 3][k] - v[e][k];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    Vector axis{};
    axis[k] = 1;
    if (separates(axis)) return false;
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    for (std::size_t e = 0; e < 3; ++e) {
      Vector cross{};
      cross[i] = -edge[e][j];
      cross[j] = edge[e][i];
      if (separates(cross)) return false;
    }
  }
  Vector normal{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    normal[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
  }
  return !separates(normal);
}

constexpr std::array<OverlapTest, 2> kTests{{
    {"akenine_moeller2001_float32", "thirteen axes", akenine_moeller2001<float>},
    {"akenine_moeller2001_float64", "thirteen axes", akenine_moeller2001<double>},
}};

}  // namespace

std::span<const OverlapTest> overlap_tests() { return kTests; }

}  // namespace sightline::contestants
