#pragma once
/// RayBoxAnswers: the answers of rays against boxes as columns. Slot i is the element i of every
/// column; it answers pair i.

#include <cstddef>
#include <cstdint>

#include "core/base/column.h"
#include "core/geometry/ray_box.h"
#include "core/geometry/vec3.h"

namespace sightline {

/// Which rays are tested against which boxes; also which points are paired (point_pairs.h).
enum class BoxPairing {
  kEach,  ///< ray i with box i; slot i
  kAll,   ///< every ray with every box; slot = ray * number of boxes + box
};

/// Which columns are computed.
enum class RayBoxDetail {
  kT,       ///< `outcome` and `t`
  kAll,     ///< all columns except `planes`
  kPlanes,  ///< all columns
};

/// The fields of RayBoxAnswer (core/geometry/ray_box.h) as columns. Columns that are not requested
/// are empty. Elements that the comments call unset have unspecified values.
struct RayBoxAnswers {
  Column<RayBoxOutcome> outcome;
  Column<std::uint8_t> inside, on_surface;    ///< 1 or 0
  Column<std::array<std::uint8_t, 2>> apart;  ///< set for kApart and kBeside
  Column<double> t, t_enter, t_exit;          ///< t is set for hits; the others as in RayBoxAnswer
  Column<BoxFaces> faces;                     ///< set for hits
  Column<Vec3d> normal;    ///< outward normal of the first face; zero if there is no face
  Column<PlaneTs> planes;  ///< the result of ray_box_planes

  std::size_t size() const { return outcome.size(); }
  /// Sets the number of pairs and the requested columns. Throws std::bad_alloc.
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
