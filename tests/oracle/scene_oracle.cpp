#include "tests/oracle/scene_oracle.h"

#include <algorithm>
#include <array>

#include "core/base/infinity.h"

namespace sightline::oracle {
namespace {

constexpr std::size_t kLeafSize = 3;

void include(Bounds& bounds, const Vec3d& p) {
  for (int axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = std::min(bounds.min[axis], p[axis]);
    bounds.max[axis] = std::max(bounds.max[axis], p[axis]);
  }
}

/// Only an order for the median; halves so that the sum stays finite.
double middle(const Triangle& triangle, int axis) {
  const auto [low, high] = std::minmax({triangle.v0[axis], triangle.v1[axis], triangle.v2[axis]});
  return 0.5 * low + 0.5 * high;
}

}  // namespace

SceneOracle::SceneOracle(std::span<const Triangle> triangles) {
  entries_.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!is_finite(triangles[i])) {
      ++dropped_not_finite_;
    } else if (!certainly_has_area(triangles[i]) && has_no_area(triangles[i])) {
      ++dropped_no_area_;
    } else {
      entries_.push_back({triangles[i], static_cast<std::uint32_t>(i)});
    }
  }
  nodes_.reserve(entries_.size());
  if (!entries_.empty()) build(entries_, 0);
}

void SceneOracle::build(std::span<Entry> entries, std::uint32_t first) {
  const std::size_t index = nodes_.size();
  Node node{{{kInf, kInf, kInf}, {-kInf, -kInf, -kInf}}, first, 0};
  Bounds middles = node.bounds;
  for (const Entry& entry : entries) {
    for (const Vec3d& v : {entry.triangle.v0, entry.triangle.v1, entry.triangle.v2})
      include(node.bounds, v);
    include(middles,
            {middle(entry.triangle, 0), middle(entry.triangle, 1), middle(entry.triangle, 2)});
  }
  nodes_.push_back(node);
  if (entries.size() <= kLeafSize) {
    nodes_[index].count = static_cast<std::uint32_t>(entries.size());
    return;
  }

  // The median along the widest axis; the depth stays below log2(n) + 1 whatever the numbers are.
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (0.5 * middles.max[k] - 0.5 * middles.min[k] >
        0.5 * middles.max[axis] - 0.5 * middles.min[axis])
      axis = k;
  }
  const std::size_t half = entries.size() / 2;
  std::nth_element(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(half),
                   entries.end(), [axis](const Entry& a, const Entry& b) {
                     return middle(a.triangle, axis) < middle(b.triangle, axis);
                   });
  build(entries.first(half), first);
  nodes_[index].first = static_cast<std::uint32_t>(nodes_.size());
  build(entries.subspan(half), first + static_cast<std::uint32_t>(half));
}

template <class Visit>
void SceneOracle::walk(const Ray& ray, Visit&& visit) const {
  if (nodes_.empty()) return;
  struct Pending {
    std::uint32_t node = 0;
    double low = 0;
  };
  std::array<Pending, 64> stack{};  // deeper than log2 of every possible count of entries
  std::size_t depth = 0;
  double bound = ray.tmax;
  const Overlap root = overlap(ray, nodes_[0].bounds, bound);
  if (!root.empty()) stack[depth++] = {0, root.low};
  while (depth > 0) {
    const Pending top = stack[--depth];
    if (top.low > bound) continue;
    const Node& node = nodes_[top.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        if (may_meet(ray, entries_[i].triangle, bound)) bound = std::min(bound, visit(entries_[i]));
        if (bound == -kInf) return;
      }
      continue;
    }
    const std::uint32_t left = top.node + 1;
    const Overlap a = overlap(ray, nodes_[left].bounds, bound);
    const Overlap b = overlap(ray, nodes_[node.first].bounds, bound);
    const bool left_first = a.low <= b.low;
    const Pending near = left_first ? Pending{left, a.low} : Pending{node.first, b.low};
    const Pending far = left_first ? Pending{node.first, b.low} : Pending{left, a.low};
    if (!(left_first ? b : a).empty()) stack[depth++] = far;
    if (!(left_first ? a : b).empty()) stack[depth++] = near;
  }
}

std::optional<OracleHit> SceneOracle::closest(const Ray& ray) const {
  std::optional<OracleHit> best;
  walk(ray, [&](const Entry& entry) {
    if (std::optional<Rational> t = least_t(ray, entry.triangle)) {
      const double rounded = round_to_double(*t);
      // Rounding is monotone, so only equal roundings need the integers.
      const int order = !best                       ? -1
                        : rounded < best->t_rounded ? -1
                        : rounded > best->t_rounded ? 1
                                                    : compare(*t, best->t);
      if (order < 0 || (order == 0 && entry.id < best->triangle))
        best = OracleHit{entry.id, std::move(*t), rounded};
    }
    // The exact t is below the next number; of equal ones the smallest id is still wanted.
    return best ? next_up(best->t_rounded) : kInf;
  });
  return best;
}

bool SceneOracle::any(const Ray& ray) const {
  bool found = false;
  walk(ray, [&](const Entry& entry) {
    found = least_t(ray, entry.triangle).has_value();
    return found ? -kInf : kInf;
  });
  return found;
}

std::vector<OracleHit> SceneOracle::all(const Ray& ray) const {
  std::vector<OracleHit> hits;
  walk(ray, [&](const Entry& entry) {
    if (std::optional<Rational> t = least_t(ray, entry.triangle)) {
      const double rounded = round_to_double(*t);
      hits.push_back({entry.id, std::move(*t), rounded});
    }
    return kInf;
  });
  std::sort(hits.begin(), hits.end(), [](const OracleHit& a, const OracleHit& b) {
    if (a.t_rounded != b.t_rounded) return a.t_rounded < b.t_rounded;
    const int order = compare(a.t, b.t);
    return order != 0 ? order < 0 : a.triangle < b.triangle;
  });
  return hits;
}

void SceneOracle::near(const Ray& ray, std::vector<std::uint32_t>& ids) const {
  ids.clear();
  if (nodes_.empty()) return;
  const Ray line{ray.origin, ray.direction, -kInf, kInf};
  std::array<std::uint32_t, 64> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (overlap(line, node.bounds, kInf).empty()) continue;
    if (node.count == 0) {
      stack[depth++] = index + 1;
      stack[depth++] = node.first;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      ids.push_back(entries_[i].id);
  }
}

}  // namespace sightline::oracle
