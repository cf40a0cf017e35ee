#pragma once
/// SinglePrimitiveMeshes: collects meshes of one primitive, which are most meshes, and loads them
/// in parallel.

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

/// A queue of meshes to load: add() each, then load(). Calls are made by one thread.
class SinglePrimitiveMeshes {
 public:
  /// All arguments must outlive the object.
  SinglePrimitiveMeshes(AccessorReader& accessors, AttributeReader& attributes,
                        const SharedBytes& shared, Budget& budget, SceneDescription& scene,
                        Warnings& warnings)
      : accessors_(accessors),
        attributes_(attributes),
        shared_(shared),
        budget_(budget),
        scene_(scene),
        warnings_(warnings) {}

  /// Appends a mesh that has its one primitive, but no positions and indices yet. `number` is its
  /// index in scene.meshes, where the pointer is null until the mesh is loaded. `mode` is glTF's
  /// mode of the primitive. Loads all waiting meshes if they are large enough in total, or if this
  /// mesh needs more than copying. Errors: those of load().
  Status add(std::uint32_t number, Mesh mesh, PrimitiveSource found, int mode, const Pose& pose);
  /// Loads all waiting meshes in parallel. The result is that of loading them one after the other:
  /// if several have errors, the first one's error is returned. Errors: GLTF_INDEX_OUT_OF_RANGE,
  /// GLTF_LIMIT_GEOMETRY_BYTES, those of pose.
  Status load();

 private:
  struct Waiting {
    std::uint32_t number;
    Mesh mesh;
    PrimitiveSource found;
    int mode;
    Pose pose;
    /// in the memory that all waiting meshes share
    std::size_t first_corner = 0, first_vertex = 0;
    /// bytes of the indices in the file, which will be read
    std::span<const std::byte> corner_bytes = {};
    /// bytes of the vertices in the file, which will be read
    std::span<const std::byte> vertex_bytes = {};
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
  std::uint64_t triangles_ = 0;  ///< triangles of all waiting meshes
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/mesh_reader_test.cpp
