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

/// The answers of core/geometry/ray_box.h, field by field.
struct RayBoxAnswers {
  Column<RayBoxOutcome> outcome;
  Column<std::uint8_t> inside, on_surface;    ///< 1 or 0
  Column<std::array<std::uint8_t, 2>> apart;  ///< of kApart and kBeside
  Column<double> t, t_enter, t_exit;          ///< t: of hits
  Column<BoxFaces> faces;                     ///< of hits
  Column<Vec3d> normal;                       ///< of the first face; zero without one
  Column<PlaneTs> planes;                     ///< only if asked for, else empty

  std::size_t size() const { return outcome.size(); }
  void resize(std::size_t count, bool with_planes) {
    outcome.resize(count);
    inside.resize(count);
    on_surface.resize(count);
    apart.resize(count);
    t.resize(count);
    t_enter.resize(count);
    t_exit.resize(count);
    faces.resize(count);
    normal.resize(count);
    planes.resize(with_planes ? count : 0);
  }
};

}  // namespace sightline
