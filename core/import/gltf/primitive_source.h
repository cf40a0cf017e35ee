#pragma once
/// PrimitiveSource: the accessors of a primitive of triangles, checked before memory is allocated
/// for its mesh.

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

inline constexpr std::uint64_t kMostVertices = 0xfffffffeu;  ///< a vertex index must fit 32 bits

/// The pose in which a node shows a mesh.
struct Pose {
  std::vector<double> weights;            ///< weights of morph targets
  const JointMatrices* joints = nullptr;  ///< matrices of the node's skin; null without one
};

/// A primitive whose views are checked. Valid while the ViewStore and the joints of its pose live.
struct PrimitiveSource {
  std::string place;  ///< "mesh 3, primitive 0"
  AccessorView positions;
  std::optional<AccessorView> indices;  ///< empty: 0, 1, 2, ...
  std::vector<WeightedTarget> targets;  ///< those whose weight is not zero
  Skinning skinning;
  /// the memory of the views if the primitive is Draco-compressed
  std::unique_ptr<const DracoMesh> decoded;
};

/// Counts the vertices of `range` as read, and prefetches those of morph targets and skin. Returns
/// the bytes of the positions that are in the file (AccessorReader::count).
std::span<const std::byte> count_vertices(const PrimitiveSource& found, const CornerRange& range,
                                          AccessorReader& accessors);

/// Finds and checks primitives. All arguments must outlive it.
class PrimitiveSources {
 public:
  PrimitiveSources(const GltfDocument& document, ViewStore& views, AccessorReader& accessors,
                   Budget& budget, Warnings& warnings)
      : document_(document),
        views_(views),
        accessors_(accessors),
        budget_(budget),
        warnings_(warnings) {}

  /// Returns the views of a primitive; decodes it if it is compressed. Precondition: the primitive
  /// has POSITION and is made of triangles. Errors: GLTF_ACCESSOR_INVALID, GLTF_SKIN_INVALID,
  /// GLTF_COMPRESSION_INVALID, GLTF_EXTENSION_UNSUPPORTED, GLTF_LIMIT_GEOMETRY_BYTES, those of
  /// AccessorReader::view.
  Result<PrimitiveSource> find(std::size_t mesh, std::size_t primitive, const Pose& pose);

 private:
  /// Decodes KHR_draco_mesh_compression. Null without the extension, and if the file does not
  /// require it and the accessors have uncompressed bytes, which are then used.
  Result<std::unique_ptr<const DracoMesh>> decoded(std::size_t mesh, std::size_t primitive,
                                                   const std::string& place);
  /// A view of an attribute: of `decoded` if not null, else of the file.
  Result<AccessorView> attribute_view(int accessor, const DecodedElements* decoded);
  Result<AccessorView> position_view(int accessor, const std::string& place,
                                     const DecodedElements* decoded);
  Result<std::optional<AccessorView>> index_view(int accessor, const std::string& place);
  Result<std::vector<WeightedTarget>> target_views(const tinygltf::Primitive& primitive,
                                                   const std::vector<double>& weights,
                                                   std::uint64_t count, const std::string& place);
  /// The views of JOINTS_n and WEIGHTS_n for n = 0, 1, ... up to the last that exists.
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
