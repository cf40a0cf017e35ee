#pragma once
/// The nodes of the chosen scene with their world matrices.

#include <vector>

#include "core/base/result.h"
#include "core/import/gltf/gltf_document.h"
#include "core/import/input/warnings.h"
#include "core/scene/scene_description.h"

namespace sightline::gltf {

/// Walks depth first from the roots, children in file order, without recursion. A root's world
/// matrix is its own; a child's is parent * child by Affine's operator*.
/// The whole file's graph is checked, also the part that is not loaded: every node has at most one
/// parent, none is its own ancestor, roots have no parent and are listed once.
/// Errors: GLTF_HIERARCHY_INVALID, GLTF_TRANSFORM_INVALID, GLTF_LIMIT_NODE_DEPTH.
Result<std::vector<Node>> walk_scene(const GltfDocument& document, const ImportLimits& limits,
                                     Warnings& warnings);

}  // namespace sightline::gltf
