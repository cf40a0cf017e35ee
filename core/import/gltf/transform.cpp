#include "core/import/gltf/transform.h"

#include "core/import/input/refusal.h"

namespace sightline::gltf {

Result<Affine> node_matrix(const tinygltf::Node& node, std::size_t index, std::string& warning) {
  auto matrix = matrix_of({node.matrix, node.translation, node.rotation, node.scale});
  if (!matrix) {
    return invalid("GLTF_TRANSFORM_INVALID",
                   "node " + std::to_string(index) + ": " + matrix.error().message,
                   "/nodes/" + std::to_string(index) + matrix.error().pointer);
  }
  const auto& r = node.rotation;
  if (node.matrix.empty() && !r.empty()) {
    const double length = Quaternion{r[0], r[1], r[2], r[3]}.norm();
    if (!(length > 0.99 && length < 1.01)) {
      warning = "node " + std::to_string(index) + ": its rotation has the squared length " +
                decimal(length) + " instead of 1 and was used as it stands";
    }
  }
  return matrix;
}

}  // namespace sightline::gltf
