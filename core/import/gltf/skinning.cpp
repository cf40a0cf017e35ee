#include "core/import/gltf/skinning.h"

#include "core/import/gltf/transform.h"
#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

Error wrong_skin(std::size_t skin, const std::string& what) {
  return invalid("GLTF_SKIN_INVALID", "skin " + std::to_string(skin) + ": " + what,
                 "/skins/" + std::to_string(skin));
}

}  // namespace

Result<std::uint64_t> pose(const Skinning& skinning, std::uint64_t first, std::uint64_t count,
                           const std::string& place, Vec3d* points) {
  std::uint64_t unbalanced = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Vec3d p = points[i];
    Vec3d q;
    double sum = 0;
    for (const InfluenceSet& set : skinning.sets) {
      double joint[4], weight[4];
      load_element(set.joints, first + i, 4, joint);
      load_element(set.weights, first + i, 4, weight);
      for (int k = 0; k < 4; ++k) {
        if (weight[k] == 0) continue;
        const auto j = static_cast<std::size_t>(joint[k]);
        if (j >= skinning.joints->size()) {
          return invalid("GLTF_INDEX_OUT_OF_RANGE",
                         place + ": vertex " + std::to_string(first + i) + " follows joint " +
                             std::to_string(j) + ", the skin has " +
                             std::to_string(skinning.joints->size()));
        }
        const Vec3d posed = (*skinning.joints)[j].apply(p);
        q.x = q.x + weight[k] * posed.x;
        q.y = q.y + weight[k] * posed.y;
        q.z = q.z + weight[k] * posed.z;
        sum = sum + weight[k];
      }
    }
    if (!(sum > 0.99 && sum < 1.01)) ++unbalanced;
    points[i] = q;
  }
  return unbalanced;
}

void warn_of_unbalanced(std::uint64_t vertices, const std::string& place, Warnings& warnings) {
  if (vertices == 0) return;
  warnings.add(place + ": the skin's weights of " + std::to_string(vertices) +
               " vertices do not sum to 1 and were used as they stand");
}

Result<const JointMatrices*> SkinReader::joints(std::size_t index) {
  auto found = known_.find(index);
  if (found == known_.end()) {
    auto matrices = read(index);
    if (!matrices) return matrices.error();
    found = known_.emplace(index, *std::move(matrices)).first;
  }
  return static_cast<const JointMatrices*>(&found->second);
}

Affine SkinReader::inverse_bind(const AccessorView& view, std::uint64_t joint, bool& is_affine) {
  double m[16];
  load_element(view, joint, 16, m);
  is_affine = m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
  Affine matrix;
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 3; ++row) matrix.m[row][column] = m[column * 4 + row];
  }
  return matrix;
}

Result<JointMatrices> SkinReader::read(std::size_t index) {
  const SkinEntry& skin = document_.skins[index];
  if (node_of_file_node_.empty()) {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) node_of_file_node_[nodes_[i].file_node] = i;
  }
  std::optional<AccessorView> binds;
  if (skin.inverse_binds.has_value()) {
    auto view = accessors_.view(*skin.inverse_binds);
    if (!view) return view.error();
    if (view->components != 16 || view->component != Component::kF32) {
      return wrong_skin(index, "inverseBindMatrices must be MAT4 of float32");
    }
    if (view->count < skin.joints.size()) {
      return wrong_skin(index, "it has " + std::to_string(skin.joints.size()) + " joints and " +
                                   std::to_string(view->count) + " inverse bind matrices");
    }
    accessors_.announce(*view, 0, skin.joints.size(), &TouchedBytes::poses);
    binds = *view;
  }
  if (Status status = budget_.spend_bytes(skin.joints.size() * sizeof(Affine)); !status) {
    return status.error();
  }
  JointMatrices matrices;
  matrices.reserve(skin.joints.size());
  for (std::size_t k = 0; k < skin.joints.size(); ++k) {
    const auto node = node_of_file_node_.find(skin.joints[k]);
    if (node == node_of_file_node_.end()) {
      return wrong_skin(index, "joint " + std::to_string(k) + " is node " +
                                   std::to_string(skin.joints[k]) +
                                   ", which is not in the loaded scene");
    }
    nodes_[node->second].is_joint = true;
    Affine matrix = nodes_[node->second].world_from_node;
    if (binds.has_value()) {
      bool is_affine = true;
      matrix = matrix * inverse_bind(*binds, k, is_affine);
      if (!is_affine) {
        warnings_.add("skin " + std::to_string(index) + ": the last row of inverse bind matrix " +
                      std::to_string(k) + " is not 0 0 0 1 and was taken as if it were");
      }
    }
    if (!is_in_range(matrix)) {
      return invalid("GLTF_TRANSFORM_INVALID",
                     "skin " + std::to_string(index) + ": the matrix of joint " +
                         std::to_string(k) + " holds more than a float32 can hold",
                     "/skins/" + std::to_string(index));
    }
    matrices.push_back(matrix);
  }
  return matrices;
}

}  // namespace sightline::gltf
