#include "core/scene/degenerate_triangles.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "core/base/column.h"
#include "core/base/parallel.h"
#include "core/geometry/exact_hit.h"

namespace sightline {

namespace {

/// Triangles that one thread reads by itself.
constexpr std::size_t kTrianglesPerPiece = 1u << 15;

Vec3d widened(const Vec3f& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// a * b - c * d is surely not zero, where each factor is the rounded difference of two float32.
/// Let u be the unit of rounding. A product is off by less than 3.01 u of itself and the difference
/// of two adds u, so the result is off by less than 4.1 u (|a b| + |c d|).
bool surely_differ(double a, double b, double c, double d) {
  // Nothing underflows: factors are 0 or at least 2^-149. u = 2^-53.
  const double first = a * b, second = c * d;
  return std::fabs(first - second) > 0x1p-50 * (std::fabs(first) + std::fabs(second));
}

/// surely_differ in float32, u = 2^-24, without a branch. No where a product may have underflown
/// (it is then off by 2^-150 at most) or overflown, and where a factor is not a number.
bool surely_differ(float a, float b, float c, float d) {
  const float first = a * b, second = c * d;
  const float sum = std::fabs(first) + std::fabs(second);
  return (sum > 0x1p-100f) & (std::fabs(first - second) > 0x1p-21f * sum);
}

/// What most triangles are, quickly: finite, and with an area as seen along axis k.
template <int k>
bool is_ordinary_along(const Vec3f& p, const Vec3f& q, const Vec3f& r) {
  constexpr int u = k == 2 ? 0 : k + 1, v = k == 0 ? 2 : k - 1;
  const float x1 = q[u] - p[u], y1 = q[v] - p[v], x2 = r[u] - p[u], y2 = r[v] - p[v];
  // Not a finite difference where a coordinate is not finite.
  const bool finite = std::isfinite((q[k] - p[k]) + (r[k] - p[k]));
  const bool differ = surely_differ(x1, y2, y1, x2);
  return finite & differ;  // without a branch between them
}

/// Precondition: finite corners.
bool has_area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  // Two corners at one place are most of those without.
  if (a == b || b == c || c == a) return false;
  const Vec3d p = widened(a), q = widened(b), r = widened(c);
  const double x1 = q.x - p.x, y1 = q.y - p.y, z1 = q.z - p.z;
  const double x2 = r.x - p.x, y2 = r.y - p.y, z2 = r.z - p.z;
  return surely_differ(x1, y2, y1, x2) || surely_differ(y1, z2, z1, y2) ||
         surely_differ(z1, x2, x1, z2) || !is_degenerate({p, q, r});
}

/// Reads triangles of a mesh, and marks their corners as used.
class Count {
 public:
  Count(const Mesh& mesh, std::uint8_t* used)
      : positions_(mesh.positions.data()), indices_(mesh.indices), used_(used) {}

  DegenerateTriangles within(std::size_t begin, std::size_t end, DegenerateTriangles found) const {
    // Neighbours are seen along the same axis.
    for (std::size_t i = begin; i < end;) {
      i = after_ordinary<0>(i, end);
      i = after_ordinary<1>(i, end);
      i = after_ordinary<2>(i, end);
      if (i < end) add(i++, found);
    }
    return found;
  }

 private:
  /// The first triangle from `i` on that is not ordinary.
  template <int k>
  std::size_t after_ordinary(std::size_t i, std::size_t end) const {
    // Of their own: a mark may be anything, as far as the compiler knows.
    const Vec3f* const positions = positions_;
    const IndexView indices = indices_;
    const auto mark = [used = used_](std::uint32_t position) {
      std::atomic_ref(used[position]).store(1, std::memory_order_relaxed);
    };
    for (; i < end; ++i) {
      const auto [a, b, c] = indices.corners(i);
      mark(a);
      mark(b);
      mark(c);
      if (!is_ordinary_along<k>(positions[a], positions[b], positions[c])) break;
    }
    return i;
  }

  void add(std::size_t i, DegenerateTriangles& found) const {
    const auto corner = indices_.corners(i);
    const Vec3f& a = positions_[corner[0]];
    const Vec3f& b = positions_[corner[1]];
    const Vec3f& c = positions_[corner[2]];
    if (!(is_finite(a) && is_finite(b) && is_finite(c))) {
      ++found.nonfinite;
    } else if (!has_area(a, b, c)) {
      ++found.degenerate;
    }
  }

  const Vec3f* const positions_;
  const IndexView indices_;
  std::uint8_t* const used_;
};

}  // namespace

DegenerateTriangles count_degenerate_triangles(const Mesh& mesh) {
  Column<std::uint8_t> used(mesh.positions.size(), 0);
  const Count count(mesh, used.data());
  DegenerateTriangles found = parallel_reduce(
      0, mesh.indices.size() / 3, kTrianglesPerPiece, DegenerateTriangles{},
      [&](std::size_t begin, std::size_t end, const DegenerateTriangles& sum) {
        return count.within(begin, end, sum);
      },
      [](const DegenerateTriangles& a, const DegenerateTriangles& b) {
        return DegenerateTriangles{a.nonfinite + b.nonfinite, a.degenerate + b.degenerate};
      });
  found.all_used = std::memchr(used.data(), 0, used.size()) == nullptr;
  return found;
}

}  // namespace sightline
