#pragma once
/// Encodes all trees of a scene as bytes of a file, so that a later run need not build them again.
///
///     header (128 bytes)   magic, version, sizes of nodes and leaves, byte order, hash of the
///                          scene's content, number of trees, hash of all records
///     record (128 bytes)   one for each tree, the top tree last: position of its arena, root,
///                          units, bounds and counts, hash of the arena
///     arenas               as they are in memory, each at a multiple of 64 bytes
///
/// Numbers have the byte order of the machine, so the file is for the machine that wrote it; the
/// header lets other machines recognise that. Trees are position independent, so an arena is used
/// in the memory into which the file was read.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/bvh/scene_tree.h"

namespace sightline {

/// Hash of everything that the trees depend on: meshes, placements, and the version of the builder.
/// Parallel. It is not cryptographic; decode_trees detects trees of another scene with an equal
/// hash.
std::uint64_t content_hash(const ScenePlan& plan);

/// The parts of a file, to be written one after the other: `head`, then the arenas. The arenas are
/// those of the encoded tree, which must outlive this struct.
struct EncodedTrees {
  std::vector<std::byte> head;
  std::vector<std::span<const std::byte>> arenas;
};
/// Encodes trees. `content` is the content_hash of the plan. Precondition: the tree is complete,
/// and build_scene_tree made it from this plan with Joining::kMeasured.
EncodedTrees encode_trees(const SceneTree& tree, std::uint64_t content);

/// Decodes the trees in `bytes`, which are aligned to 64 bytes and valid while `owner` lives; they
/// are not copied. The bytes are not trusted: every tree that is returned has passed validate.h
/// against the plan's triangles, so it cannot change answers. Errors: TREES_FOREIGN (not a file of
/// trees), TREES_STALE (another content, version or machine), TREES_DAMAGED. Throws std::bad_alloc.
/// Cost: about a tenth of building the trees.
Result<SceneTree> decode_trees(const ScenePlan& plan, std::uint64_t content,
                               std::span<const std::byte> bytes,
                               const std::shared_ptr<const void>& owner);

}  // namespace sightline
