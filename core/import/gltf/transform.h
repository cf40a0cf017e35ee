#pragma once
/// The transform that a file states for a node.

#include <tiny_gltf.h>

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/scene/node_transform.h"

namespace sightline::gltf {

/// The node's matrix, or that of its TRS, or the identity. Errors: GLTF_TRANSFORM_INVALID where
/// matrix_of has TRANSFORM_INVALID.
/// warning  set when the rotation's squared length is not within 1% of 1
Result<Affine> node_matrix(const tinygltf::Node& node, std::size_t index, std::string& warning);

}  // namespace sightline::gltf
