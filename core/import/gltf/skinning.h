#pragma once
/// Skins: moves vertices by the matrices of joints, which are the file's own nodes [glTF2] 3.7.3.

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

/// Four joints and four weights for each vertex: the accessors JOINTS_n and WEIGHTS_n.
struct InfluenceSet {
  AccessorView joints;
  AccessorView weights;
};

/// The matrices of a skin's joints: joint k has world_from_node(joint k) * inverse_bind(k), by
/// Affine's operator*.
using JointMatrices = std::vector<Affine>;

/// The skin of a primitive. Without sets the primitive has none. `joints` is null without a skin,
/// and must outlive this struct.
struct Skinning {
  const JointMatrices* joints = nullptr;
  std::vector<InfluenceSet> sets;
};

/// Poses `count` vertices in place; points[0] is vertex number `first`. For each component, in
/// float64 without FMA, over sets and joints in the order of the file, without weights of zero:
///   q = 0;  q = q + w_k * (J_k p)  with J_k p by Affine::apply
/// Weights are used as stored (integers by glTF's formula); they are not normalised to the sum 1.
/// Returns the number of vertices whose weights do not sum to 1 within 1%. Errors:
/// GLTF_INDEX_OUT_OF_RANGE naming `place`.
Result<std::uint64_t> pose(const Skinning& skinning, std::uint64_t first, std::uint64_t count,
                           const std::string& place, Vec3d* points);

/// Adds a warning that the weights of so many vertices do not sum to 1; no warning for 0.
void warn_of_unbalanced(std::uint64_t vertices, const std::string& place, Warnings& warnings);

/// Joint matrices of a file's skins. Each skin is computed when first needed, and then cached. Not
/// thread-safe.
class SkinReader {
 public:
  /// nodes  nodes of the loaded scene; joints() sets Node::is_joint
  /// All arguments must outlive the reader.
  SkinReader(const GltfDocument& document, AccessorReader& accessors, Budget& budget,
             std::vector<Node>& nodes, Warnings& warnings)
      : document_(document),
        accessors_(accessors),
        budget_(budget),
        nodes_(nodes),
        warnings_(warnings) {}

  /// Returns the matrices of a skin; they live as long as the reader. Precondition: index is in
  /// range. Errors: GLTF_SKIN_INVALID (a joint outside of the loaded scene; inverse bind matrices
  /// of another type or too few), GLTF_TRANSFORM_INVALID, GLTF_LIMIT_GEOMETRY_BYTES, those of
  /// AccessorReader::view.
  Result<const JointMatrices*> joints(std::size_t index);

 private:
  Result<JointMatrices> read(std::size_t index);
  /// Reads an inverse bind matrix; ignores its last row. Sets is_affine to false if that row is not
  /// 0 0 0 1.
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
