#pragma once
/// MeshReader: reads a mesh of a file when a node first needs it, once for each pose.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "core/base/result.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/attribute_reader.h"
#include "core/import/gltf/corners.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/primitive_source.h"
#include "core/import/gltf/single_primitive_meshes.h"
#include "core/import/gltf/skinning.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Adds meshes to a scene description: mesh_of() for each node that shows a mesh, then finish().
/// Not thread-safe.
class MeshReader {
 public:
  /// `shared` and `copies_attributes` are those of AttributeReader. All arguments must outlive the
  /// reader.
  MeshReader(const GltfDocument& document, AccessorReader& accessors, const SharedBytes& shared,
             bool copies_attributes, Budget& budget, SceneDescription& scene, Warnings& warnings)
      : document_(document),
        accessors_(accessors),
        limits_(budget.limits()),
        budget_(budget),
        scene_(scene),
        warnings_(warnings),
        sources_(document, accessors.views(), accessors, budget, warnings),
        attributes_(document, accessors, shared, copies_attributes, budget, warnings),
        single_primitive_(accessors, attributes_, shared, budget, scene, warnings),
        skins_(document, accessors, budget, scene.nodes, warnings) {}

  /// Returns the index in scene.meshes of the mesh that a node shows; empty if it has no triangles.
  /// Nodes that show one mesh with equal morph weights and the same skin share the index. The
  /// positions of a skinned mesh are in world space, whatever the node's matrix. Only the vertices
  /// that triangles use are read. The mesh in scene.meshes may be null until finish().
  /// Precondition: scene.nodes is complete. Errors: GLTF_INDEX_OUT_OF_RANGE, GLTF_LIMIT_TRIANGLES,
  /// GLTF_LIMIT_GEOMETRY_BYTES, those of PrimitiveSources::find and SkinReader::joints.
  Result<std::optional<std::uint32_t>> mesh_of(const tinygltf::Node& node);
  /// Reads the meshes that are not read yet. Must be called at the end, also after an error of
  /// mesh_of. An error of finish() belongs to an earlier mesh, so the caller reports it instead of
  /// the error of mesh_of. Errors: those of mesh_of.
  Status finish() { return single_primitive_.load(); }
  /// The number of meshes of the file that mesh_of was called for.
  std::size_t shown() const;

 private:
  /// Vertices of an accessor (and its morph targets) that are in the mesh already.
  struct Loaded {
    std::uint32_t low = 0, high = 0, base = 0;
  };
  using LoadedParts = std::map<std::vector<int>, Loaded>;

  /// Opens a primitive and checks it before memory is allocated for it. Empty if it has no
  /// triangles.
  Result<std::optional<PrimitiveSource>> open_primitive(std::size_t number, const Pose& pose,
                                                        Mesh& mesh);
  Result<std::optional<std::uint32_t>> read_lone(Mesh mesh, const Pose& pose);
  Result<std::optional<std::uint32_t>> read_joined(Mesh mesh, const Pose& pose);
  Status append_primitive(std::size_t number, const Pose& pose, Mesh& mesh, LoadedParts& loaded);
  /// Appends the vertices of `range` to the mesh unless they are in it; returns the index of the
  /// first.
  Result<std::uint32_t> append_positions(const tinygltf::Primitive& source,
                                         const PrimitiveSource& found, const CornerRange& range,
                                         Mesh& mesh, LoadedParts& loaded);
  const tinygltf::Primitive& source_of(const Mesh& mesh, std::size_t number) const {
    return document_.model.meshes[mesh.file_mesh].primitives[number];
  }

  const GltfDocument& document_;
  AccessorReader& accessors_;
  const ImportLimits& limits_;
  Budget& budget_;
  SceneDescription& scene_;
  Warnings& warnings_;
  PrimitiveSources sources_;
  AttributeReader attributes_;
  SinglePrimitiveMeshes single_primitive_;
  SkinReader skins_;
  /// By mesh, morph weights and skin: the result of mesh_of.
  std::map<std::tuple<int, std::vector<double>, int>, std::optional<std::uint32_t>> known_;
};

}  // namespace sightline::gltf
