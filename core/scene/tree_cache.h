#pragma once
/// All trees of a scene as bytes, so that a later run need not build them again.
///
///     header (128 bytes)   magic, version, the sizes of nodes and leaves, byte order,
///                          hash of the scene's content, number of trees, hash of all records
///     record (128 bytes)   one for each tree, the one over the placements last: where its arena
///                          stands, its root, units, bounds and counts, hash of the arena
///     arenas               as they are in memory, each from a multiple of 64 bytes on
///
/// Numbers are as this machine has them: the file is for the machine that wrote it, and another one
/// sees by the header that it is not meant. Trees are position independent, so an
/// arena is used where it is read to.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/bvh/scene_tree.h"

namespace sightline {

/// Of everything that the trees depend on: meshes, placements, and the version of the builder.
/// Parallel. Scenes that somebody made to have the same one are told apart by decode_trees.
std::uint64_t content_hash(const ScenePlan& plan);

/// To be written one after the other. The arenas are those of the tree.
struct EncodedTrees {
  std::vector<std::byte> head;
  std::vector<std::span<const std::byte>> arenas;
};
/// Precondition: the tree is complete, and build_scene_tree made it from a plan of that content
/// with Joining::kMeasured.
EncodedTrees encode_trees(const SceneTree& tree, std::uint64_t content);

/// The trees in `bytes`, which are aligned to 64 bytes and owned by `owner`; they are not copied.
/// The bytes are hostile. Whatever they contain, a tree that is returned has passed validate.h, and
/// answers are those of the plan's triangles. Errors: TREES_FOREIGN (no such file), TREES_STALE (of
/// another content, version or machine), TREES_DAMAGED. Throws std::bad_alloc. Cost: about a tenth
/// of building them.
Result<SceneTree> decode_trees(const ScenePlan& plan, std::uint64_t content,
                               std::span<const std::byte> bytes,
                               const std::shared_ptr<const void>& owner);

}  // namespace sightline
