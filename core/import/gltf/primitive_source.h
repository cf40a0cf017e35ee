#pragma once
/// The parts of a primitive of triangles, found and checked before anything is allocated for it.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/import/codec/draco_mesh.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/corners.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/gltf/positions.h"
#include "core/import/gltf/skinning.h"
#include "core/import/gltf/view_store.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"

namespace sightline::gltf {

inline constexpr std::uint64_t kMostVertices = 0xfffffffeu;  ///< so that an index is a u32

/// How a node shows a mesh.
struct Pose {
  std::vector<double> weights;            ///< of morph targets
  const JointMatrices* joints = nullptr;  ///< of its skin, if it has one
};

struct PrimitiveSource {
  std::string place;  ///< "mesh 3, primitive 0"
  AccessorView positions;
  std::optional<AccessorView> indices;
  std::vector<WeightedTarget> targets;
  Skinning skinning;
  std::unique_ptr<const DracoMesh> decoded;  ///< what the views point into, when it was compressed
};

/// Counts its vertices of `range`, which will be read, and has those of targets and skin fetched.
/// Returned are the positions that are the file's (AccessorReader::count).
std::span<const std::byte> count_vertices(const PrimitiveSource& found, const CornerRange& range,
                                          AccessorReader& accessors);

class PrimitiveSources {
 public:
  PrimitiveSources(const GltfDocument& document, ViewStore& views, AccessorReader& accessors,
                   Budget& budget, Warnings& warnings)
      : document_(document),
        views_(views),
        accessors_(accessors),
        budget_(budget),
        warnings_(warnings) {}

  /// Precondition: the primitive has POSITION and is made of triangles.
  /// Errors: GLTF_ACCESSOR_INVALID, GLTF_SKIN_INVALID, GLTF_COMPRESSION_INVALID,
  /// GLTF_EXTENSION_UNSUPPORTED, GLTF_LIMIT_GEOMETRY_BYTES, those of AccessorReader::view.
  Result<PrimitiveSource> find(std::size_t mesh, std::size_t primitive, const Pose& pose);

 private:
  /// What KHR_draco_mesh_compression holds. nullptr without the extension, and when the file does
  /// not require it and the accessors have bytes of their own: those are what was compressed.
  Result<std::unique_ptr<const DracoMesh>> decoded(std::size_t mesh, std::size_t primitive,
                                                   const std::string& place);
  /// The view of an attribute, decoded or in the file.
  Result<AccessorView> attribute_view(int accessor, const DecodedElements* decoded);
  Result<AccessorView> position_view(int accessor, const std::string& place,
                                     const DecodedElements* decoded);
  Result<std::optional<AccessorView>> index_view(int accessor, const std::string& place);
  Result<std::vector<WeightedTarget>> target_views(const tinygltf::Primitive& primitive,
                                                   const std::vector<double>& weights,
                                                   std::uint64_t count, const std::string& place);
  /// JOINTS_n and WEIGHTS_n for n = 0, 1, ... as far as there are any.
  Result<std::vector<InfluenceSet>> influence_sets(const tinygltf::Primitive& primitive,
                                                   const PrimitiveSource& found,
                                                   const DracoEntry* draco);
  void check_stated_bounds(int accessor, const std::string& place);

  const GltfDocument& document_;
  ViewStore& views_;
  AccessorReader& accessors_;
  Budget& budget_;
  Warnings& warnings_;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/attribute_reader_test.cpp
