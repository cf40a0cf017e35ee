#pragma once
/// Rays against boxes as columns: slot i answers pair i.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/ray_box.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// Which rays meet which boxes.
enum class BoxPairing {
  kEach,  ///< ray i and box i
  kAll,   ///< every ray and every box; slot = ray * boxes + box
};

/// How much of an answer is computed.
enum class RayBoxDetail {
  kT,       ///< the outcome and t
  kAll,     ///< everything but planes
  kPlanes,  ///< everything
};

/// The answers of core/geometry/ray_box.h, field by field. Columns that are not asked for are empty.
struct RayBoxAnswers {
  Column<RayBoxOutcome> outcome;
  Column<std::uint8_t> inside, on_surface;    ///< 1 or 0
  Column<std::array<std::uint8_t, 2>> apart;  ///< of kApart and kBeside
  Column<double> t, t_enter, t_exit;          ///< t: of hits
  Column<BoxFaces> faces;                     ///< of hits
  Column<Vec3d> normal;                       ///< of the first face; zero without one
  Column<PlaneTs> planes;

  std::size_t size() const { return outcome.size(); }
  void resize(std::size_t count, RayBoxDetail detail) {
    outcome.resize(count);
    t.resize(count);
    const std::size_t all = detail == RayBoxDetail::kT ? 0 : count;
    inside.resize(all);
    on_surface.resize(all);
    apart.resize(all);
    t_enter.resize(all);
    t_exit.resize(all);
    faces.resize(all);
    normal.resize(all);
    planes.resize(detail == RayBoxDetail::kPlanes ? count : 0);
  }
};

}  // namespace sightline

// Tests: tests/unit/run/boxes_test.cpp
