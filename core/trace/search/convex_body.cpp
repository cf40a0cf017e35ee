#include "core/trace/search/convex_body.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/geometry/triangle_crossing.h"

namespace sightline {
namespace {

auto key_of(const Vec3d& p) { return std::tuple(p.x, p.y, p.z); }

}  // namespace

std::optional<ConvexBody> ConvexBody::of(std::span<const Triangle> triangles) {
  if (triangles.empty() || triangles.size() > kMostTriangles) return std::nullopt;
  ConvexBody body;
  using Key = std::tuple<double, double, double>;
  std::map<std::pair<Key, Key>, std::pair<Segment, int>> edges;
  for (const Triangle& t : triangles) {
    const std::array<Vec3d, 3> corner{t.v0, t.v1, t.v2};
    body.corners_.insert(body.corners_.end(), corner.begin(), corner.end());
    body.faces_.push_back({Segment{t.v0, t.v1}, Segment{t.v0, t.v2}});
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d &p = corner[i], &q = corner[(i + 1) % 3];
      const auto place = edges.try_emplace(std::minmax(key_of(p), key_of(q)), Segment{p, q}, 0);
      ++place.first->second.second;
    }
  }
  for (const auto& [key, edge] : edges) {
    if (edge.second != 2) return std::nullopt;
    body.edges_.push_back(edge.first);
  }
  const auto comes_before = [](const Vec3d& p, const Vec3d& q) { return key_of(p) < key_of(q); };
  const auto is_same = [](const Vec3d& p, const Vec3d& q) { return key_of(p) == key_of(q); };
  std::sort(body.corners_.begin(), body.corners_.end(), comes_before);
  body.corners_.erase(std::unique(body.corners_.begin(), body.corners_.end(), is_same),
                      body.corners_.end());
  for (const Triangle& t : triangles) {
    int least = 0, most = 0;
    for (const Vec3d& p : body.corners_) {
      const int side = volume_sign(t.v0, t.v1, t.v2, p);
      least = std::min(least, side);
      most = std::max(most, side);
    }
    // A flat body has no inside.
    if ((least < 0) == (most > 0)) return std::nullopt;
  }
  return body;
}

std::optional<ExactDistance> penetration_depth(const ConvexBody& a, const ConvexBody& b,
                                               const Deadline& deadline) {
  auto found = penetration(a.parts(), b.parts(), deadline);
  if (!found) return std::nullopt;
  return std::move(found->depth);
}

}  // namespace sightline
