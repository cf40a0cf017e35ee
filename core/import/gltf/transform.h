#pragma once
/// The matrix of a node, from its matrix or from translation, rotation and scale.

#include <tiny_gltf.h>

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/scene/node_transform.h"

namespace sightline::gltf {

/// Returns the node's matrix, or that of its translation, rotation and scale (from_trs), or the
/// identity. `index` is the node's index in the file, for messages. Sets `warning` to a sentence if
/// the squared length of the rotation is not within 1% of 1. Errors:
/// GLTF_TRANSFORM_INVALID if matrix_of returns TRANSFORM_INVALID.
Result<Affine> node_matrix(const tinygltf::Node& node, std::size_t index, std::string& warning);

}  // namespace sightline::gltf
