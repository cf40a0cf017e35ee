#include "tests/oracle/hull_distance.h"

#include <optional>

namespace sightline::oracle {
namespace {

mpq_class dot(const ExactPoint& a, const ExactPoint& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
ExactPoint minus(const ExactPoint& a, const ExactPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Gaussian elimination; empty where the rows are dependent.
std::optional<std::vector<mpq_class>> solve(std::vector<std::vector<mpq_class>> rows) {
  const std::size_t n = rows.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t pivot = i;
    while (pivot < n && rows[pivot][i] == 0) ++pivot;
    if (pivot == n) return std::nullopt;
    std::swap(rows[i], rows[pivot]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const mpq_class factor = rows[r][i] / rows[i][i];
      for (std::size_t c = i; c <= n; ++c) rows[r][c] -= factor * rows[i][c];
    }
  }
  std::vector<mpq_class> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = rows[i][n] / rows[i][i];
  return x;
}

std::vector<ExactPoint> chosen(const std::vector<ExactPoint>& from, std::size_t bits) {
  std::vector<ExactPoint> some;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if ((bits >> i & 1u) != 0) some.push_back(from[i]);
  }
  return some;
}

}  // namespace

ExactPoint exact_point(const Vec3d& p) { return {mpq_class(p.x), mpq_class(p.y), mpq_class(p.z)}; }

mpq_class hull_square_distance(const std::vector<ExactPoint>& a, const std::vector<ExactPoint>& b,
                               ExactPoint* away) {
  std::optional<mpq_class> least;
  for (std::size_t in_a = 1; in_a < std::size_t{1} << a.size(); ++in_a) {
    for (std::size_t in_b = 1; in_b < std::size_t{1} << b.size(); ++in_b) {
      const std::vector<ExactPoint> p = chosen(a, in_a), q = chosen(b, in_b);
      // p0 - q0 + sum x_i e_i is to be short.
      std::vector<ExactPoint> e;
      for (std::size_t i = 1; i < p.size(); ++i) e.push_back(minus(p[i], p[0]));
      for (std::size_t j = 1; j < q.size(); ++j) e.push_back(minus(q[0], q[j]));
      const ExactPoint w = minus(p[0], q[0]);
      std::vector<std::vector<mpq_class>> rows;
      for (const ExactPoint& row : e) {
        std::vector<mpq_class> numbers;
        numbers.reserve(e.size() + 1);
        for (const ExactPoint& column : e) numbers.push_back(dot(row, column));
        numbers.push_back(-dot(row, w));
        rows.push_back(numbers);
      }
      const auto x = solve(rows);
      if (!x) continue;
      mpq_class first_a = 1, first_b = 1;
      ExactPoint apart = w;
      bool is_inside = true;
      for (std::size_t i = 0; i < x->size(); ++i) {
        (i + 1 < p.size() ? first_a : first_b) -= (*x)[i];
        is_inside = is_inside && (*x)[i] >= 0;
        for (std::size_t k = 0; k < 3; ++k) apart[k] += (*x)[i] * e[i][k];
      }
      if (!is_inside || first_a < 0 || first_b < 0) continue;
      const mpq_class square = dot(apart, apart);
      if (least && square >= *least) continue;
      least = square;
      if (away != nullptr) *away = apart;
    }
  }
  return *least;
}

bool meets_all(const Triangle& triangle, const std::vector<ExactHalfSpace>& planes) {
  const std::array<ExactPoint, 3> corner{exact_point(triangle.v0), exact_point(triangle.v1),
                                         exact_point(triangle.v2)};
  // In weights u, v of the second and third corner: a u + b v <= c.
  struct Line {
    mpq_class a, b, c;
  };
  std::vector<Line> lines{{-1, 0, 0}, {0, -1, 0}, {1, 1, 1}};
  const ExactPoint ab = minus(corner[1], corner[0]), ac = minus(corner[2], corner[0]);
  for (const ExactHalfSpace& plane : planes) {
    lines.push_back({dot(plane.normal, ab), dot(plane.normal, ac),
                     plane.offset - dot(plane.normal, corner[0])});
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t j = i + 1; j < lines.size(); ++j) {
      const Line &p = lines[i], &q = lines[j];
      const mpq_class determinant = p.a * q.b - p.b * q.a;
      if (determinant == 0) continue;
      const mpq_class u = (p.c * q.b - p.b * q.c) / determinant,
                      v = (p.a * q.c - p.c * q.a) / determinant;
      bool in_all = true;
      for (const Line& line : lines) in_all = in_all && line.a * u + line.b * v <= line.c;
      if (in_all) return true;
    }
  }
  return false;
}

}  // namespace sightline::oracle
