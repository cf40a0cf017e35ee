#pragma once
/// Nodes that clients add to a scene and remove from it.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/result.h"
#include "core/scene/poser.h"
#include "core/scene/scene_description.h"

namespace sightline {

/// By the number of a node, Node::file_node: its index in SceneDescription::nodes. Those of removed
/// nodes are there too.
using NodeNumbers = std::unordered_map<std::uint32_t, std::uint32_t>;
NodeNumbers numbers_of(const SceneDescription& scene);

/// The largest number of an added node: answers and tables with int32 can hold it.
inline constexpr std::uint32_t kLargestAddedNode = 0x7ffffffe;
/// The JSON pointer of a change, after so many `sampled` ones that no body has.
std::string pointer_of_change(std::size_t index, std::size_t sampled);
/// The error NODE_NOT_FOUND.
Error no_such_node(std::uint32_t number, std::string pointer);

/// Checks that a node has a mesh that nothing poses. Errors, with the pointer:
///   NODE_MESHLESS  it has no triangles
///   NODE_POSED     a skin or morph targets pose its mesh
Status check_unposed(const SceneDescription& scene, std::uint32_t node, const std::string& pointer);

/// Appends the nodes that the changes from `sampled` on add, in their order, and their instances,
/// and adds their numbers to `numbers`. Each node has an instance for each instance of the node
/// that it copies. World matrices and masks are not set. Errors, with the pointer of the change:
///   NUMBER_OUT_OF_RANGE  the number exceeds kLargestAddedNode
///   NODE_EXISTS    the number is that of another node, of the file or removed
///   NODE_NOT_FOUND in /copy_of or /parent
///   those of check_unposed in /copy_of
Status add_nodes(SceneDescription& scene, std::span<const NodeChange> changes, std::size_t sampled,
                 NodeNumbers& numbers);
/// How many nodes and instances a scene has after changes; without a limit of numbers, as far as
/// add_nodes does not refuse them.
struct EditedSize {
  std::uint64_t nodes = 0, instances = 0;
};
EditedSize size_after(const SceneDescription& scene, std::span<const NodeChange> changes);
/// Takes from removed nodes (Node::removed) their names, meshes and cameras. Their instances get a
/// mesh without triangles; a mesh that no other node shows becomes one, unless it is held
/// (edited_meshes.h). Adds such meshes to `posed`.
void clear_removed_nodes(SceneDescription& scene, const std::vector<bool>& held,
                         PosedMeshes& posed);

}  // namespace sightline

// Tests: tests/unit/run/moved_test.cpp
