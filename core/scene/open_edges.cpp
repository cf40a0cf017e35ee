#include "core/scene/open_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <tuple>
#include <vector>

namespace sightline {

namespace {

/// For each position the number of the first that is the same point; -0 and 0 are.
std::vector<std::uint32_t> same_points(const Mesh& mesh) {
  const auto& positions = mesh.positions;
  const auto key = [&](std::uint32_t i) {
    const Vec3f& p = positions[i];
    return std::make_tuple(p.x, p.y, p.z);
  };
  const auto is_point = [&](std::uint32_t i) {
    const Vec3f& p = positions[i];
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  std::vector<std::uint32_t> order(positions.size()), first(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto end = std::partition(order.begin(), order.end(), is_point);
  std::sort(order.begin(), end, [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (auto i = order.begin(); i != order.end(); ++i) {
    first[*i] = i != order.begin() && i < end && key(*i) == key(*(i - 1)) ? first[*(i - 1)] : *i;
  }
  return first;
}

/// Calls edge(from, to) for each edge of each triangle that counts.
template <class Edge>
void for_each_edge(const Mesh& mesh, const std::vector<std::uint32_t>& first,
                   const std::function<bool(std::size_t)>& counts, Edge edge) {
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    if (!counts(p)) continue;
    const Primitive& primitive = mesh.primitives[p];
    for (std::uint32_t t = 0; t < primitive.triangle_count; ++t) {
      const auto corner = mesh.indices.corners(std::size_t{primitive.first_triangle} + t);
      const auto is_finite = [&](std::uint32_t i) {
        const Vec3f& at = mesh.positions[i];
        return std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z);
      };
      if (!is_finite(corner[0]) || !is_finite(corner[1]) || !is_finite(corner[2])) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t from = first[corner[i]], to = first[corner[(i + 1) % 3]];
        if (from != to) edge(from, to);
      }
    }
  }
}

}  // namespace

OpenEdges open_edges(const Mesh& mesh, const std::function<bool(std::size_t primitive)>& counts) {
  const std::vector<std::uint32_t> first = same_points(mesh);
  // The edges at each point that begin or end there and lead to a larger number.
  std::vector<std::uint64_t> begin(first.size() + 1, 0);
  for_each_edge(mesh, first, counts, [&](std::uint32_t from, std::uint32_t to) {
    ++begin[std::size_t{std::min(from, to)} + 1];
  });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  struct End {
    std::uint32_t point;
    std::int32_t direction;  ///< 1: walked towards it, -1: away from it
  };
  std::vector<End> ends(begin.back());
  std::vector<std::uint64_t> next(begin.begin(), begin.end() - 1);
  for_each_edge(mesh, first, counts, [&](std::uint32_t from, std::uint32_t to) {
    ends[next[std::min(from, to)]++] = {std::max(from, to), from < to ? 1 : -1};
  });

  OpenEdges open;
  for (std::size_t point = 0; point + 1 < begin.size(); ++point) {
    const auto from = ends.begin() + static_cast<std::ptrdiff_t>(begin[point]);
    const auto to = ends.begin() + static_cast<std::ptrdiff_t>(begin[point + 1]);
    std::sort(from, to, [](const End& a, const End& b) { return a.point < b.point; });
    for (auto i = from; i != to;) {
      std::int64_t balance = 0, uses = 0;
      const std::uint32_t other = i->point;
      for (; i != to && i->point == other; ++i, ++uses) balance += i->direction;
      open.unpaired += uses % 2 != 0 ? 1u : 0u;
      open.unbalanced += balance != 0 ? 1u : 0u;
    }
  }
  return open;
}

}  // namespace sightline
