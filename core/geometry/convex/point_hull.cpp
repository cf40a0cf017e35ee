#include "core/geometry/convex/point_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "core/geometry/dyadic_vector.h"
#include "core/geometry/exact_hit.h"
#include "core/geometry/rounding.h"
#include "core/geometry/triangle_crossing.h"
#include "core/geometry/triangle_within.h"

namespace sightline {
namespace {

auto key_of(const Vec3d& p) { return std::tuple(p.x, p.y, p.z); }

int side_of(const Triangle& plane, const Vec3d& p) {
  return volume_sign(plane.v0, plane.v1, plane.v2, p);
}

bool are_apart(const Box3d& a, const Triangle& t) {
  for (int k = 0; k < 3; ++k) {
    if (std::min({t.v0[k], t.v1[k], t.v2[k]}) > a.max[k] ||
        std::max({t.v0[k], t.v1[k], t.v2[k]}) < a.min[k]) {
      return true;
    }
  }
  return false;
}

/// A part of the length of an edge, at least 0 and at most 1.
struct Part {
  Dyadic numerator, denominator;
};
bool is_less(const Part& a, const Part& b) {
  return compare(a.numerator * b.denominator, b.numerator * a.denominator) < 0;
}

}  // namespace

Box3d outer_bounds(const PointHull& hull) {
  Box3d box{hull.points[0], hull.points[0]};
  for (const Vec3d& p : hull.points) {
    for (int k = 0; k < 3; ++k) {
      box.min[k] = std::min(box.min[k], p[k]);
      box.max[k] = std::max(box.max[k], p[k]);
    }
  }
  return box;
}

ConvexHull::ConvexHull(const PointHull& hull) : points_(hull.points), bounds_(outer_bounds(hull)) {
  const auto& p = points_;
  Face first{0, 0, 0};
  const auto count = static_cast<std::uint32_t>(p.size());
  std::uint32_t next = 1;
  while (next < count && p[next] == p[0]) ++next;
  first[1] = next % count;
  while (next < count && is_degenerate({p[0], p[first[1]], p[next]})) ++next;
  if (next == count) {
    const auto [low, high] = std::minmax_element(
        p.begin(), p.end(), [](const Vec3d& a, const Vec3d& b) { return key_of(a) < key_of(b); });
    segment_ = Capsule{*low, *high, 0};
    return;
  }
  first[2] = next;
  while (next < count && volume_sign(p[0], p[first[1]], p[first[2]], p[next]) == 0) ++next;
  if (next == count) {
    find_polygon(first);
  } else {
    find_faces(first, next);
  }
}

/// The faces are triangles whose corners run counter-clockwise as seen from outside. A point beyond
/// a face takes the place of all faces whose planes do not have it strictly inside. So no new face
/// is without an area: the plane of the neighbour that stays does not contain the point.
void ConvexHull::find_faces(const Face& first, std::uint32_t fourth) {
  const auto& p = points_;
  const std::size_t count = p.size();
  auto [a, b, c] = first;
  if (volume_sign(p[a], p[b], p[c], p[fourth]) > 0) std::swap(b, c);
  std::vector<Face> kept;
  faces_ = {{a, b, c}, {a, fourth, b}, {b, fourth, c}, {c, fourth, a}};
  std::vector<std::array<std::uint32_t, 2>> edges;  // of the faces that go
  std::vector<unsigned char> is_edge(count * count);
  for (std::uint32_t i = 0; i < count; ++i) {
    kept.clear();
    edges.clear();
    bool is_beyond = false;
    for (const Face& face : faces_) {
      const int side = volume_sign(p[face[0]], p[face[1]], p[face[2]], p[i]);
      is_beyond = is_beyond || side > 0;
      if (side < 0) {
        kept.push_back(face);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) edges.push_back({face[k], face[(k + 1) % 3]});
    }
    if (!is_beyond) continue;
    for (const auto& [from, to] : edges) is_edge[from * count + to] = 1;
    for (const auto& [from, to] : edges) {
      if (is_edge[to * count + from] == 0) kept.push_back({from, to, i});
    }
    for (const auto& [from, to] : edges) is_edge[from * count + to] = 0;
    faces_.swap(kept);
  }
  for (const Face& face : faces_) planes_.push_back({p[face[0]], p[face[1]], p[face[2]]});
}

/// All points lie in one plane: its planes are that one from both sides, and one through each edge
/// along an axis that is not in the plane.
void ConvexHull::find_polygon(const Face& first) {
  const Vec3d &a = points_[first[0]], &b = points_[first[1]], &c = points_[first[2]];
  planes_.push_back({a, b, c});
  planes_.push_back({a, c, b});
  const DyadicVector n = cross(difference(b, a), difference(c, a));
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (n[static_cast<std::size_t>(axis)].abs() < n[static_cast<std::size_t>(k)].abs()) axis = k;
  }
  // Along the axis the points are seen as those of a plane.
  const auto seen = [&](const Vec3d& p, double height) {
    Vec3d q = p;
    q[axis] = height;
    return q;
  };
  const auto turn = [&](const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    return volume_sign(seen(p, 0), seen(q, 0), seen(r, 0), seen(p, 1));
  };
  std::vector<Vec3d> sorted(points_.begin(), points_.end());
  std::sort(sorted.begin(), sorted.end(), [&](const Vec3d& p, const Vec3d& q) {
    return key_of(seen(p, 0)) < key_of(seen(q, 0));
  });
  // Both chains from the first point to the last one.
  std::vector<Vec3d>& polygon = polygon_;
  for (int chain = 0; chain < 2; ++chain) {
    const std::size_t begin = polygon.size();
    for (const Vec3d& p : sorted) {
      while (polygon.size() >= begin + 2 && turn(polygon.end()[-2], polygon.back(), p) <= 0)
        polygon.pop_back();
      polygon.push_back(p);
    }
    polygon.pop_back();
    std::reverse(sorted.begin(), sorted.end());
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()],
                &inner = polygon[(i + 2) % polygon.size()];
    const Triangle plane{p, q, seen(p, p[axis] == 0 ? 1 : 0)};
    planes_.push_back(side_of(plane, inner) < 0 ? plane : Triangle{plane.v1, plane.v0, plane.v2});
  }
}

BodyParts ConvexHull::parts() const {
  const auto& p = points_;
  BodyParts parts;
  if (segment_) {
    parts.corners.push_back(segment_->from);
    if (segment_->from == segment_->to) return parts;
    parts.corners.push_back(segment_->to);
    parts.edges.push_back({segment_->from, segment_->to});
    return parts;
  }
  parts.corners = polygon_;
  for (std::size_t i = 0; i < polygon_.size(); ++i)
    parts.edges.push_back({polygon_[i], polygon_[(i + 1) % polygon_.size()]});
  if (!polygon_.empty()) {
    parts.faces.push_back({Segment{polygon_[0], polygon_[1]}, Segment{polygon_[0], polygon_[2]}});
  }
  // By edge, in both directions: the face's third corner.
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> third;
  std::vector<bool> is_corner(p.size());
  for (const Face& face : faces_) {
    const auto& [a, b, c] = face;
    parts.faces.push_back({Segment{p[a], p[b]}, Segment{p[a], p[c]}});
    for (std::size_t k = 0; k < 3; ++k) {
      third[{face[k], face[(k + 1) % 3]}] = face[(k + 2) % 3];
      is_corner[face[k]] = true;
    }
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (is_corner[i]) parts.corners.push_back(p[i]);
  }
  for (const auto& [edge, corner] : third) {
    const auto [from, to] = edge;
    if (from < to && volume_sign(p[from], p[to], p[corner], p[third.at({to, from})]) != 0)
      parts.edges.push_back({p[from], p[to]});
  }
  return parts;
}

bool ConvexHull::contains(const Vec3d& p) const {
  if (segment_) return is_within(p, *segment_);
  return std::all_of(planes_.begin(), planes_.end(),
                     [&](const Triangle& plane) { return side_of(plane, p) <= 0; });
}

/// A plane with corners of the triangle strictly outside, and how far the corners are from it.
struct ConvexHull::Cut {
  const Triangle* plane = nullptr;
  std::array<VolumeEstimate, 3> height;
  std::array<int, 3> side{};

  Dyadic exact_height(const Vec3d& p) const {
    return exact_volume(plane->v0, plane->v1, plane->v2, p);
  }
};

bool ConvexHull::meets(const Triangle& triangle) const {
  if (!is_finite(triangle) || are_apart(bounds_, triangle)) return false;
  if (segment_) return triangle_meets_box(triangle, *segment_);
  const std::array<const Vec3d*, 3> corner{&triangle.v0, &triangle.v1, &triangle.v2};
  std::array<bool, 3> is_inside{true, true, true};
  std::vector<Cut> cuts;
  for (const Triangle& plane : planes_) {
    Cut cut;
    cut.plane = &plane;
    int most = -1, least = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      cut.height[i] = estimate_volume(plane.v0, plane.v1, plane.v2, *corner[i]);
      cut.side[i] = cut.height[i].certain_sign();
      if (cut.side[i] == 0) cut.side[i] = side_of(plane, *corner[i]);
      is_inside[i] = is_inside[i] && cut.side[i] <= 0;
      most = std::max(most, cut.side[i]);
      least = std::min(least, cut.side[i]);
    }
    if (least > 0) return false;
    if (most > 0) cuts.push_back(cut);
  }
  if (is_degenerate(triangle)) return false;
  if (is_inside[0] || is_inside[1] || is_inside[2]) return true;
  const Vec3d *below = nullptr, *above = nullptr;
  for (const Vec3d& p : points_) {
    const int side = side_of(triangle, p);
    if (side <= 0) below = &p;
    if (side >= 0) above = &p;
    if (below != nullptr && above != nullptr) break;
  }
  if (below == nullptr || above == nullptr) return false;
  for (std::size_t from = 0; from < 3; ++from) {
    if (edge_meets(cuts, triangle, from)) return true;
  }
  return triangle_meets_box(triangle, Capsule{*below, *above, 0});
}

/// The edge from corner `from` to the next one; both are outside of the hull. An edge enters a
/// half-space, or leaves it, at the part |h| / (|h| + |g|) of its length if the heights of its ends
/// are h and g.
bool ConvexHull::edge_meets(std::span<const Cut> cuts, const Triangle& triangle, std::size_t from) {
  const std::size_t to = (from + 1) % 3;
  struct Crossing {
    const Cut* cut;
    double low, high;
  };
  std::vector<Crossing> enters, leaves;
  double last_enter = 0, first_leave = 1;  // the former is at least, the latter at most this
  double sure_enter = 0, sure_leave = 1;   // the other way round
  for (const Cut& cut : cuts) {
    const int begin = cut.side[from], end = cut.side[to];
    if (begin > 0 && end > 0) return false;
    if (begin <= 0 && end <= 0) continue;
    const VolumeEstimate &h = cut.height[from], &g = cut.height[to];
    const double h_value = std::fabs(h.value), g_value = std::fabs(g.value);
    const double h_low = std::max(h_value - h.error, 0.0), h_high = h_value + h.error;
    const double g_low = std::max(g_value - g.error, 0.0), g_high = g_value + g.error;
    Crossing crossing{&cut, h_low / (h_low + g_high) * (1 - 0x1p-50),
                      h_high / (h_high + g_low) * (1 + 0x1p-50)};
    if (!(h_high + g_high < kInfD)) crossing = {&cut, 0, 1};
    if (begin > 0) {
      last_enter = std::max(last_enter, crossing.low);
      sure_enter = std::max(sure_enter, crossing.high);
      enters.push_back(crossing);
    } else {
      first_leave = std::min(first_leave, crossing.high);
      sure_leave = std::min(sure_leave, crossing.low);
      leaves.push_back(crossing);
    }
  }
  if (last_enter > first_leave) return false;
  if (sure_enter < sure_leave) return true;
  const Vec3d& begin = from == 0 ? triangle.v0 : from == 1 ? triangle.v1 : triangle.v2;
  const Vec3d& end = to == 0 ? triangle.v0 : to == 1 ? triangle.v1 : triangle.v2;
  const auto exact = [&](const Crossing& crossing) {
    const Dyadic h = crossing.cut->exact_height(begin).abs();
    return Part{h, h + crossing.cut->exact_height(end).abs()};
  };
  std::optional<Part> enter, leave;
  for (const Crossing& crossing : enters) {
    if (crossing.high < last_enter) continue;
    Part part = exact(crossing);
    if (!enter || is_less(*enter, part)) enter = std::move(part);
  }
  for (const Crossing& crossing : leaves) {
    if (crossing.low > first_leave) continue;
    Part part = exact(crossing);
    if (!leave || is_less(part, *leave)) leave = std::move(part);
  }
  return !enter || !leave || !is_less(*leave, *enter);
}

}  // namespace sightline
