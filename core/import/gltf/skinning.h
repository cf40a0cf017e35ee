#pragma once
/// Skins, posed by the file's own node transforms [glTF2] 3.7.3.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/affine.h"
#include "core/import/gltf/accessor.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/budget.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Four joints and their weights for each vertex: JOINTS_n and WEIGHTS_n.
struct InfluenceSet {
  AccessorView joints;
  AccessorView weights;
};

/// Joint k's matrix is world_from_node(joint k) * inverse_bind(k), by Affine's operator*.
using JointMatrices = std::vector<Affine>;

/// How a primitive is bound to a skin; without sets it is not.
struct Skinning {
  const JointMatrices* joints = nullptr;
  std::vector<InfluenceSet> sets;
};

/// Poses `count` vertices, `first` being the number of points[0]. Per component, in float64 without
/// FMA, over sets and joints in file order, weights of zero left out:
///   q = 0;  q = q + w_k * (J_k p)  with J_k p by Affine::apply
/// Weights are taken as they stand (integers by glTF's formula), not made to sum to 1.
/// Gives the number of vertices whose weights do not sum to 1 within 1%.
/// Errors: GLTF_INDEX_OUT_OF_RANGE naming `place`.
Result<std::uint64_t> pose(const Skinning& skinning, std::uint64_t first, std::uint64_t count,
                           const std::string& place, Vec3d* points);

/// Says of how many vertices the weights do not, if of any.
void warn_of_unbalanced(std::uint64_t vertices, const std::string& place, Warnings& warnings);

/// Joint matrices of a file's skins, each computed when first needed.
class SkinReader {
 public:
  /// nodes  nodes of the loaded scene; joints() sets Node::is_joint; all arguments must outlive the
  ///        reader
  SkinReader(const GltfDocument& document, AccessorReader& accessors, Budget& budget,
             std::vector<Node>& nodes, Warnings& warnings)
      : document_(document),
        accessors_(accessors),
        budget_(budget),
        nodes_(nodes),
        warnings_(warnings) {}

  /// Precondition: index is in range. Errors: GLTF_SKIN_INVALID (a joint outside of the loaded
  /// scene, inverse bind matrices of another type or too few), GLTF_TRANSFORM_INVALID,
  /// GLTF_LIMIT_GEOMETRY_BYTES, those of AccessorReader::view.
  Result<const JointMatrices*> joints(std::size_t index);

 private:
  Result<JointMatrices> read(std::size_t index);
  /// An inverse bind matrix; what its last row holds instead of 0 0 0 1 is left out.
  Affine inverse_bind(const AccessorView& view, std::uint64_t joint, bool& is_affine);

  const GltfDocument& document_;
  AccessorReader& accessors_;
  Budget& budget_;
  std::vector<Node>& nodes_;
  Warnings& warnings_;
  std::map<std::uint32_t, std::uint32_t> node_of_file_node_;
  std::map<std::size_t, JointMatrices> known_;
};

}  // namespace sightline::gltf
