#pragma once
/// Whether a mesh is closed, by its edges: what lies inside is only defined where it is.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/scene/mesh.h"

namespace sightline {

/// Edges are the same where their ends are the same points; triangles that are not finite have
/// none.
struct OpenEdges {
  /// Edges of an odd number of triangles. None: every ray that leaves crosses the mesh an odd
  /// number of times from a point inside, an even number from outside.
  std::uint64_t unpaired = 0;
  /// Edges that the triangles beside them do not walk as often in one direction as in the other.
  /// None: fronts less backs is the same along every ray that leaves.
  std::uint64_t unbalanced = 0;
};

/// Of the triangles of those primitives for which `counts(primitive)` is true. Errors: DEADLINE,
/// CANCELLED. Throws std::bad_alloc. Cost: some 10 ns for each position and each edge.
Result<OpenEdges> open_edges(const Mesh& mesh,
                             const std::function<bool(std::size_t primitive)>& counts,
                             const Deadline& deadline);
/// Memory of open_edges: 24 bytes a triangle, and some 20 a position.
std::uint64_t open_edges_bytes(const Mesh& mesh,
                               const std::function<bool(std::size_t primitive)>& counts);

/// The open edges of the whole meshes of a scene. They are computed when first requested, then
/// cached. May be used from many threads.
class KnownEdges {
 public:
  explicit KnownEdges(std::size_t meshes) : slots_(std::make_unique<Slot[]>(meshes)) {}
  /// `mesh` has this number. One thread at a time processes a mesh; other threads wait for it,
  /// until their own deadlines. If it runs out of time, the next thread starts again. Errors: those
  /// of open_edges, and of `reserve`, which is called only where the result is not cached.
  Result<OpenEdges> of(std::uint32_t number, const Mesh& mesh, const Deadline& deadline,
                       const ReserveBytes& reserve);

 private:
  enum class State : std::uint8_t { kUnknown, kUnderWay, kKnown };
  struct Slot {
    OpenEdges edges;  ///< once it is known
    std::atomic<State> state{State::kUnknown};
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<Slot[]> slots_;
};

}  // namespace sightline
