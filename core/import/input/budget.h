#pragma once
/// Budget: how many triangles and bytes the limits of an import still allow. All parts of an import
/// share one budget.

#include <cstdint>

#include "core/base/result.h"
#include "core/import/input/limits.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

/// Counts down triangles and bytes from ImportLimits. Not thread-safe. The limits must outlive the
/// budget.
class Budget {
 public:
  explicit Budget(const ImportLimits& limits)
      : limits_(limits), triangles_(limits.triangles), bytes_(limits.geometry_bytes) {}

  const ImportLimits& limits() const { return limits_; }
  /// Triangles that may still be added.
  std::uint64_t triangles() const { return triangles_; }
  /// The total number of triangles if `more_triangles` were added to those spent so far.
  std::uint64_t with(std::uint64_t more_triangles) const {
    return limits_.triangles - triangles_ + more_triangles;
  }
  /// Takes triangles from the budget. Precondition: count <= triangles().
  void spend_triangles(std::uint64_t count) { triangles_ -= count; }

  /// Takes bytes from the budget, or returns GLTF_LIMIT_GEOMETRY_BYTES and takes none.
  Status spend_bytes(std::uint64_t count) {
    if (count > bytes_) {
      return beyond_limit("GEOMETRY_BYTES", "bytes of positions, indices and instances in memory",
                          limits_.geometry_bytes - bytes_ + count, limits_.geometry_bytes);
    }
    bytes_ -= count;
    return success();
  }
  /// Returns bytes to the budget after their memory was freed.
  void return_bytes(std::uint64_t count) { bytes_ += count; }

 private:
  const ImportLimits& limits_;
  std::uint64_t triangles_;
  std::uint64_t bytes_;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/attribute_reader_test.cpp
