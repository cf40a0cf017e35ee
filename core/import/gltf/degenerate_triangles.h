#pragma once
/// Reports the triangles of a mesh that have no area in mesh space.

#include "core/import/input/warnings.h"
#include "core/scene/degenerate_triangles.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Adds what was found in a mesh to `counts`, and adds a warning if there are such triangles.
void add_degenerate_triangles(const DegenerateTriangles& found, const Mesh& mesh,
                              ImportCounts& counts, Warnings& warnings);

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
