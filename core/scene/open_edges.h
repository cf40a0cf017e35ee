#pragma once
/// Counts the open edges of a mesh. It is closed if it has none: unpaired edges for parity,
/// unbalanced edges for winding numbers.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/scene/mesh.h"

namespace sightline {

/// Counts of the open edges of a mesh. Two edges are the same if their ends have equal coordinates.
/// Edges between equal points, and triangles that are not finite, are not counted.
struct OpenEdges {
  /// Edges that an odd number of triangles have. If there are none, a ray to infinity crosses the
  /// mesh an odd number of times from a point inside, and an even number of times from a point
  /// outside.
  std::uint64_t unpaired = 0;
  /// Edges that their triangles do not run along equally often in both directions. If there are
  /// none, the number of fronts minus backs is the same along every ray to infinity from a point.
  std::uint64_t unbalanced = 0;
};

/// An unbalanced edge, by indices in Mesh::positions: the triangles run from `from` to `to` so many
/// times more often than back. `times` may be negative.
struct UnbalancedEdge {
  std::uint32_t from = 0, to = 0;
  std::int64_t times = 0;
};

/// Counts the open edges of the triangles of those primitives for which `counts(primitive)` is
/// true; `primitive` is an index in Mesh::primitives. Appends the unbalanced edges to `unbalanced`
/// if it is given. Errors: DEADLINE, CANCELLED. Throws std::bad_alloc. Cost: about 10 ns for each
/// position and each edge.
Result<OpenEdges> open_edges(const Mesh& mesh,
                             const std::function<bool(std::size_t primitive)>& counts,
                             const Deadline& deadline,
                             std::vector<UnbalancedEdge>* unbalanced = nullptr);
/// The bytes of memory that open_edges allocates: 24 for each triangle, about 20 for each position.
std::uint64_t open_edges_bytes(const Mesh& mesh,
                               const std::function<bool(std::size_t primitive)>& counts);

/// The open edges of the whole meshes of a scene, computed on first request and then cached.
/// Thread-safe.
class KnownEdges {
 public:
  /// For a scene of so many meshes.
  explicit KnownEdges(std::size_t meshes) : slots_(std::make_unique<Slot[]>(meshes)) {}
  /// Returns the open edges of `mesh`, all of its primitives; `number` is its index in the scene.
  /// One thread computes them; other threads that request them wait until their own deadlines. If
  /// the thread runs out of time, the next one starts again. Errors: those of open_edges and of
  /// `reserve`, which is called only if the result is not cached.
  Result<OpenEdges> of(std::uint32_t number, const Mesh& mesh, const Deadline& deadline,
                       const ReserveBytes& reserve);

 private:
  enum class State : std::uint8_t { kUnknown, kUnderWay, kKnown };
  struct Slot {
    OpenEdges edges;  ///< valid in state kKnown
    std::atomic<State> state{State::kUnknown};
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<Slot[]> slots_;
};

}  // namespace sightline
