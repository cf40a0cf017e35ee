#include "core/import/gltf/degenerate_triangles.h"

#include <string>

namespace sightline::gltf {

void add_degenerate_triangles(const DegenerateTriangles& found, const Mesh& mesh,
                              ImportCounts& counts, Warnings& warnings) {
  counts.degenerate_triangles += found.degenerate;
  counts.nonfinite_triangles += found.nonfinite;
  if (found.nonfinite == 0) return;
  warnings.add("mesh " + std::to_string(mesh.file_mesh) + ": " + std::to_string(found.nonfinite) +
               " triangles have a corner that is not finite and are never hit");
}

}  // namespace sightline::gltf
