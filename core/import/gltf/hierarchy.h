#pragma once
/// Lists the nodes of the chosen scene with their world matrices.

#include <vector>

#include "core/base/result.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Returns the nodes of the loaded scene, in the order of a depth-first walk from its roots,
/// children in the order of the file.
/// The world matrix of a root is its own matrix; that of a child is parent * child by Affine's
/// operator*. Checks the graph of the whole file, including parts that are not loaded: a node has
/// at most one parent and is not its own ancestor; roots have no parent and are listed once.
/// Errors: GLTF_HIERARCHY_INVALID, GLTF_TRANSFORM_INVALID, GLTF_LIMIT_NODE_DEPTH.
Result<std::vector<Node>> walk_scene(const GltfDocument& document, const ImportLimits& limits,
                                     Warnings& warnings);

}  // namespace sightline::gltf
