#include "core/scene/open_edges.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <numeric>
#include <span>
#include <vector>

#include "core/geometry/triangle.h"

namespace sightline {

namespace {

constexpr std::uint32_t kEmpty = 0xffffffffu;
/// Steps that miss the cache, each.
constexpr std::uint64_t kStepsPerLook = 4096;

std::uint64_t slot_hash(const Vec3f& p) {
  // -0 and 0 are the same point.
  const auto bits = [](float x) { return std::uint64_t{std::bit_cast<std::uint32_t>(x + 0.0f)}; };
  std::uint64_t hash = bits(p.x) | bits(p.y) << 32;
  hash = (hash ^ hash >> 32) * 0x9e3779b97f4a7c15u;
  hash = (hash ^ hash >> 29 ^ bits(p.z)) * 0xbf58476d1ce4e5b9u;
  return hash ^ hash >> 32;
}

std::size_t table_size(std::size_t positions) {
  return std::bit_ceil(positions + positions / 2 + 1);
}

/// For each position the number of the first that is the same point; cut short where the watch has
/// passed.
std::vector<std::uint32_t> same_points(const Mesh& mesh, DeadlineWatch& watch) {
  const std::span<const Vec3f> positions = mesh.positions;
  std::vector<std::uint32_t> first(positions.size()), table(table_size(positions.size()), kEmpty);
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    first[i] = i;
    const Vec3f& p = positions[i];
    if (!is_finite(p)) continue;
    std::size_t slot = slot_hash(p);
    // A file whose author knows the hash can make positions meet in one slot: the deadline bounds
    // that.
    for (;; ++slot) {
      if (watch.passed()) return {};
      std::uint32_t& other = table[slot & (table.size() - 1)];
      if (other == kEmpty) other = i;
      const Vec3f& q = positions[other];
      if (p.x != q.x || p.y != q.y || p.z != q.z) continue;
      first[i] = other;
      break;
    }
  }
  return first;
}

/// Calls edge(from, to) for each edge of each triangle that counts, until the watch has passed.
template <class Edge>
void for_each_edge(const Mesh& mesh, const std::vector<std::uint32_t>& first,
                   const std::function<bool(std::size_t)>& counts, DeadlineWatch& watch,
                   Edge edge) {
  const std::span<const Vec3f> at = mesh.positions;
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    if (watch.passed()) return;
    if (!counts(p)) continue;
    const Primitive& primitive = mesh.primitives[p];
    for (std::uint32_t t = 0; t < primitive.triangle_count; ++t) {
      if (watch.passed()) return;
      const auto corner = mesh.indices.corners(std::size_t{primitive.first_triangle} + t);
      if (!is_finite(at[corner[0]]) || !is_finite(at[corner[1]]) || !is_finite(at[corner[2]]))
        continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t from = first[corner[i]], to = first[corner[(i + 1) % 3]];
        if (from != to) edge(from, to);
      }
    }
  }
}

/// An edge at the end that has the smaller number.
struct End {
  std::uint32_t point;     ///< the other one
  std::int32_t direction;  ///< 1: walked towards it, -1: away from it
};

}  // namespace

std::uint64_t open_edges_bytes(const Mesh& mesh,
                               const std::function<bool(std::size_t primitive)>& counts) {
  std::uint64_t triangles = 0;
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p)
    triangles += counts(p) ? mesh.primitives[p].triangle_count : 0;
  const std::uint64_t positions = mesh.positions.size();
  const std::uint64_t same = table_size(mesh.positions.size()) * sizeof(std::uint32_t);
  const std::uint64_t edges =
      (positions + 1) * 2 * sizeof(std::uint64_t) + 3 * triangles * sizeof(End);
  return positions * sizeof(std::uint32_t) + std::max(same, edges);
}

Result<OpenEdges> open_edges(const Mesh& mesh,
                             const std::function<bool(std::size_t primitive)>& counts,
                             const Deadline& deadline, std::vector<UnbalancedEdge>* unbalanced) {
  DeadlineWatch watch(deadline, kStepsPerLook);
  const std::vector<std::uint32_t> first = same_points(mesh, watch);
  if (watch.passed(0)) return watch.error();
  // The edges at each point that lead to a larger number: where they end, and once they are
  // written, from the last to the first, where they begin.
  std::vector<std::uint64_t> begin(first.size() + 1, 0);
  for_each_edge(mesh, first, counts, watch,
                [&](std::uint32_t from, std::uint32_t to) { ++begin[std::min(from, to)]; });
  if (watch.passed(0)) return watch.error();
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<End> ends(begin.back());
  for_each_edge(mesh, first, counts, watch, [&](std::uint32_t from, std::uint32_t to) {
    ends[--begin[std::min(from, to)]] = {std::max(from, to), from < to ? 1 : -1};
  });
  if (watch.passed(0)) return watch.error();

  OpenEdges open;
  // Of the edges at one point, by their other end: how often walked towards it, less how often away
  // from it. It is odd where the uses are.
  std::vector<std::int64_t> balance(first.size(), 0);
  for (std::size_t point = 0; point < first.size(); ++point) {
    const std::span here(ends.data() + begin[point], begin[point + 1] - begin[point]);
    if (watch.passed(1 + here.size())) return watch.error();
    for (const End& end : here) balance[end.point] += end.direction;
    for (const End& end : here) {
      std::int64_t& its = balance[end.point];
      open.unpaired += its % 2 != 0 ? 1u : 0u;
      open.unbalanced += its != 0 ? 1u : 0u;
      if (its != 0 && unbalanced != nullptr)
        unbalanced->push_back({static_cast<std::uint32_t>(point), end.point, its});
      its = 0;
    }
  }
  return open;
}

Result<OpenEdges> KnownEdges::of(std::uint32_t number, const Mesh& mesh, const Deadline& deadline,
                                 const ReserveBytes& reserve) {
  constexpr auto kAll = [](std::size_t) { return true; };
  // How soon a waiting thread sees that its time was used up.
  constexpr std::chrono::milliseconds kLook{20};
  Slot& slot = slots_[number];
  if (slot.state.load(std::memory_order_acquire) == State::kKnown) return slot.edges;
  if (Status status = ask_for(reserve, open_edges_bytes(mesh, kAll)); !status)
    return std::move(status).error();
  std::unique_lock hold(mutex_);
  while (slot.state.load(std::memory_order_relaxed) == State::kUnderWay) {
    if (deadline.passed()) return out_of_time(deadline);
    changed_.wait_for(hold, kLook);
  }
  if (slot.state.load(std::memory_order_relaxed) == State::kKnown) return slot.edges;
  slot.state.store(State::kUnderWay, std::memory_order_relaxed);
  hold.unlock();
  const auto end = [&](State state) {
    {
      const std::lock_guard held(mutex_);
      slot.state.store(state, std::memory_order_release);
    }
    changed_.notify_all();
  };
  try {
    auto found = open_edges(mesh, kAll, deadline);
    if (found) slot.edges = *found;
    end(found ? State::kKnown : State::kUnknown);
    return found;
  } catch (...) {
    end(State::kUnknown);
    throw;
  }
}

}  // namespace sightline
