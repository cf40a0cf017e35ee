#include "core/geometry/point_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/float64_vector.h"
#include "core/geometry/rounding.h"

namespace sightline {

namespace {

constexpr std::size_t next(std::size_t corner) { return (corner + 1) % 3; }

using namespace float64;

/// The corners as the point sees them.
std::array<Numbers, 3> seen_from(const Vec3d& point, const Triangle& triangle) {
  return {minus(triangle.v0, point), minus(triangle.v1, point), minus(triangle.v2, point)};
}

}  // namespace

DistanceRange distance_range(const Vec3d& point, const Triangle& triangle) {
  const std::array<Numbers, 3> corner = seen_from(point, triangle);
  const double size = std::max({largest(corner[0]), largest(corner[1]), largest(corner[2])});
  if (!(size < 0x1p400) || size < 0x1p-400) return {0, kInfD};
  const Numbers ab = minus(corner[1], corner[0]), ac = minus(corner[2], corner[0]);
  const auto [v, w] = near_weights(corner, ab, ac);
  Numbers near;
  for (std::size_t k = 0; k < 3; ++k) near[k] = (corner[0][k] + v * ab[k]) + w * ac[k];

  const double error = 64 * kU * size;
  const double length = std::sqrt(dot(near, near));
  DistanceRange range{0, length + error};
  if (length <= error) return range;
  // No point of the triangle is nearer than its nearest corner in the direction of `near`.
  const double least = std::min({dot(corner[0], near), dot(corner[1], near), dot(corner[2], near)});
  range.low = std::max(0.0, least / length - error);
  return range;
}

CornerSet certain_nearest_edge(const Vec3d& point, const Triangle& triangle) {
  const std::array<Numbers, 3> corner = seen_from(point, triangle);
  const std::array<Numbers, 3> edge{minus(triangle.v1, triangle.v0),
                                    minus(triangle.v2, triangle.v1),
                                    minus(triangle.v0, triangle.v2)};
  const double size = std::max({largest(corner[0]), largest(corner[1]), largest(corner[2])});
  const double extent = std::max({largest(edge[0]), largest(edge[1]), largest(edge[2])});
  if (!(size < 0x1p200) || !(extent > 0x1p-200)) return 0;
  // How far the point lies along an edge, seen from its first and from its second end.
  const double error = 32 * kU * extent * size;
  std::array<double, 3> after, beyond;
  for (std::size_t i = 0; i < 3; ++i) {
    after[i] = -dot(corner[i], edge[i]);
    beyond[i] = -dot(corner[next(i)], edge[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (after[i] < -error && beyond[next(next(i))] > error) return CornerSet{1} << i;
  }
  const Numbers normal = cross(edge[0], edge[1]);
  const double side_error = 256 * kU * extent * extent * extent * size;
  for (std::size_t i = 0; i < 3; ++i) {
    if (after[i] > error && beyond[i] < -error &&
        dot(normal, cross(edge[i], corner[i])) > side_error) {
      return CornerSet{1} << i | CornerSet{1} << next(i);
    }
  }
  return 0;
}

namespace {

DyadicVector difference(const Vec3d& a, const DyadicVector& b) {
  return {Dyadic(a.x) - b[0], Dyadic(a.y) - b[1], Dyadic(a.z) - b[2]};
}

/// Where the nearest point lies, in exact numbers.
class ExactNearest {
 public:
  enum class Part { kCorner, kEdge, kInside };

  ExactNearest(const DyadicVector& point, const Triangle& triangle)
      : corner_{difference(triangle.v0, point), difference(triangle.v1, point),
                difference(triangle.v2, point)},
        edge_{difference(triangle.v1, triangle.v0), difference(triangle.v2, triangle.v1),
              difference(triangle.v0, triangle.v2)},
        normal_(cross(edge_[0], edge_[1])) {
    find();
  }

  Part part() const { return part_; }
  std::size_t at() const { return at_; }
  const DyadicVector& normal() const { return normal_; }

  ExactDistance distance() const {
    const DyadicVector& from = corner_[at_];
    if (part_ == Part::kCorner) return {dot(from, from), Dyadic(1.0)};
    if (part_ == Part::kEdge) {
      const DyadicVector side = cross(from, edge_[at_]);
      return {dot(side, side), length_};
    }
    const Dyadic height = dot(normal_, from);
    return {height * height, dot(normal_, normal_)};
  }

  /// From the nearest point to the point, of some length.
  DyadicVector away() const {
    DyadicVector v = normal_;
    const bool is_reversed = part_ != Part::kInside || !in_front();
    for (std::size_t k = 0; k < 3; ++k) {
      if (part_ == Part::kCorner) v[k] = corner_[at_][k];
      if (part_ == Part::kEdge) v[k] = corner_[at_][k] * length_ + edge_[at_][k] * along_;
      if (is_reversed) v[k] = -v[k];
    }
    return v;
  }

  /// Weights of the corners, over divisor().
  std::array<Dyadic, 3> weights() const {
    std::array<Dyadic, 3> weight;
    if (part_ == Part::kCorner) {
      weight[at_] = Dyadic(1.0);
    } else if (part_ == Part::kEdge) {
      weight[at_] = length_ - along_;
      weight[next(at_)] = along_;
    } else {
      for (std::size_t i = 0; i < 3; ++i) weight[next(next(i))] = inward(i);
    }
    return weight;
  }
  Dyadic divisor() const {
    if (part_ == Part::kCorner) return Dyadic(1.0);
    return part_ == Part::kEdge ? length_ : dot(normal_, normal_);
  }
  /// Whether the point lies on the counter-clockwise side.
  bool in_front() const { return dot(normal_, corner_[0]).sign() < 0; }

 private:
  /// How far the point lies on the inner side of edge i, in units of the normal's square.
  Dyadic inward(std::size_t i) const { return -dot(normal_, cross(edge_[i], corner_[i])); }

  void find() {
    std::array<Dyadic, 3> along, length;
    for (std::size_t i = 0; i < 3; ++i) {
      along[i] = -dot(corner_[i], edge_[i]);
      length[i] = dot(edge_[i], edge_[i]);
    }
    for (at_ = 0; at_ < 3; ++at_) {
      const std::size_t before = next(next(at_));
      if (along[at_].sign() <= 0 && compare(along[before], length[before]) >= 0) return;
    }
    part_ = Part::kEdge;
    for (at_ = 0; at_ < 3; ++at_) {
      if (along[at_].sign() > 0 && compare(along[at_], length[at_]) < 0 &&
          inward(at_).sign() <= 0) {
        along_ = along[at_];
        length_ = length[at_];
        return;
      }
    }
    part_ = Part::kInside;
    at_ = 0;
  }

  const std::array<DyadicVector, 3> corner_;  ///< as the point sees them
  const std::array<DyadicVector, 3> edge_;    ///< from corner i to the next
  const DyadicVector normal_;
  Part part_ = Part::kCorner;
  std::size_t at_ = 0;     ///< the corner, or where the edge begins
  Dyadic along_, length_;  ///< of an edge: where on it, over its squared length
};

}  // namespace

ExactDistance exact_distance(const DyadicVector& point, const Triangle& triangle) {
  return ExactNearest(point, triangle).distance();
}

ExactDistance exact_distance(const Vec3d& point, const Triangle& triangle) {
  return exact_distance(exact_vector(point), triangle);
}

DyadicVector away_from(const Triangle& triangle, const Vec3d& point) {
  return ExactNearest(exact_vector(point), triangle).away();
}

int compare(const ExactDistance& a, const ExactDistance& b) {
  return compare(a.square * b.divisor, b.square * a.divisor);
}

int compare(const ExactDistance& a, double distance) {
  if (std::isinf(distance)) return -1;
  const Dyadic other(distance);
  return compare(a.square, other * other * a.divisor);
}

NearestDetail nearest_detail(const Vec3d& point, const Triangle& triangle) {
  return nearest_detail(exact_vector(point), triangle);
}

NearestDetail nearest_detail(const DyadicVector& point, const Triangle& triangle) {
  const ExactNearest nearest(point, triangle);
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  const std::array<Dyadic, 3> weight = nearest.weights();
  const Dyadic divisor = nearest.divisor();

  NearestDetail result;
  result.on_edge = nearest.part() != ExactNearest::Part::kInside;
  ExactDetail& detail = result.detail;
  for (int k = 0; k < 3; ++k) {
    Dyadic sum;
    for (std::size_t i = 0; i < 3; ++i) {
      if (weight[i].sign() != 0) sum = sum + weight[i] * Dyadic((*corner[i])[k]);
    }
    detail.position[k] = round_quotient(sum, divisor);
  }
  detail.u = round_quotient(weight[1], divisor);
  detail.v = round_quotient(weight[2], divisor);
  const DyadicVector& n = nearest.normal();
  const Dyadic square = dot(n, n);
  detail.normal = {round_over_root(n[0], square), round_over_root(n[1], square),
                   round_over_root(n[2], square)};
  detail.front = nearest.in_front();
  return result;
}

}  // namespace sightline
