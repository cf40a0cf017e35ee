#pragma once
/// Meshes of one primitive, as nearly all are: found one after the other, loaded side by side.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/attribute_reader.h"
#include "core/import/gltf/corners.h"
#include "core/import/gltf/degenerate_triangles.h"
#include "core/import/gltf/primitive_source.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

class SinglePrimitiveMeshes {
 public:
  /// All of these must outlive it.
  SinglePrimitiveMeshes(AccessorReader& accessors, AttributeReader& attributes,
                        const SharedBytes& shared, Budget& budget, SceneDescription& scene,
                        Warnings& warnings)
      : accessors_(accessors),
        attributes_(attributes),
        shared_(shared),
        budget_(budget),
        scene_(scene),
        warnings_(warnings) {}

  /// Takes on a mesh that has its one primitive, but no positions and no indices: it is
  /// scene.meshes[number], which is null until load. Loads all that wait where that is worth it,
  /// or where this one needs more than copying. Errors: as load.
  Status add(std::uint32_t number, Mesh mesh, PrimitiveSource found, int mode, const Pose& pose);
  /// Loads all that wait. Parallel, each as if it were alone: the error is that of the first one
  /// that has any. Errors: GLTF_INDEX_OUT_OF_RANGE, GLTF_LIMIT_GEOMETRY_BYTES, those of pose.
  Status load();

 private:
  struct Waiting {
    std::uint32_t number;
    Mesh mesh;
    PrimitiveSource found;
    int mode;
    Pose pose;
    std::size_t first_corner = 0, first_vertex = 0;  ///< in the memory that all of them share
    std::span<const std::byte> corner_bytes = {};    ///< of the file, about to be read
    std::span<const std::byte> vertex_bytes = {};    ///< likewise
    std::optional<Result<CornerRange>> range = {};
    std::optional<Result<std::uint64_t>> unbalanced = {};
    DegenerateTriangles degenerate_triangles = {};
  };

  void load_corners(Waiting& one, const std::shared_ptr<UnsetColumn<std::uint32_t>>& memory);
  Status place_vertices(Waiting& one, std::size_t& vertices);
  void load_vertices(Waiting& one, const std::shared_ptr<UnsetColumn<Vec3f>>& memory);
  Status finish(Waiting& one);

  AccessorReader& accessors_;
  AttributeReader& attributes_;
  const SharedBytes& shared_;
  Budget& budget_;
  SceneDescription& scene_;
  Warnings& warnings_;
  std::vector<Waiting> waiting_;
  std::uint64_t triangles_ = 0;  ///< of those that wait
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
