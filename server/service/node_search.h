#pragma once
/// Searches the nodes of a scene by name, path, material or instance, and writes them as JSON.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/watch.h"
#include "core/scene/scene.h"

namespace sightline {

/// The names from the root down to a node, "/house/roof". A node without a name is "#7", its index
/// in the file. Of a path beyond 4 KiB the end, after "...".
/// node  index in SceneDescription::nodes
std::string node_path(const SceneDescription& scene, std::uint32_t node);

/// Which nodes a client requests: those that satisfy every condition that is set.
struct NodeQuery {
  std::optional<std::string> name;  ///< glob pattern of the name
  std::optional<std::string> path;  ///< glob pattern of node_path
  /// glob pattern of a material of the node's own triangles
  std::optional<std::string> material;
  std::optional<std::uint32_t> instance;  ///< the node that has this instance
  std::uint64_t first = 0;                ///< number of matching nodes to leave out
  std::uint64_t limit = 1000;             ///< most nodes of the answer
  bool with_path = false, with_materials = false, with_extras = false, with_pose = false;
};

/// The nodes of an answer.
struct NodePage {
  std::vector<std::uint32_t> nodes;  ///< indices in SceneDescription::nodes
  std::uint64_t total = 0;           ///< matching nodes of the scene
};

/// Bytes that find_nodes and encode_nodes allocate for each node of the scene.
inline constexpr std::uint64_t kNodeSearchBytes = 40;

/// Finds the nodes in the order of a depth-first walk. Errors: the deadline of `watch`.
/// Cost: a comparison of patterns for each node.
Result<NodePage> find_nodes(const Scene& scene, const NodeQuery& query, DeadlineWatch& watch);

/// Bytes of the text of encode_nodes.
std::uint64_t bytes_of_nodes(const Scene& scene, const NodeQuery& query, const NodePage& page);

/// Returns {"total":5,"nodes":[{"node_id","name","parent","children","instances","first_instance",
/// "triangles","triangles_below","hidden","mask","bounds":{"min","max"}}],"next":2}. "total" counts
/// all matching nodes; "next" is absent at the end. Instances, triangles and world bounds are those
/// of the node itself; "triangles_below" includes all nodes below it. "bounds" may be null; "parent"
/// is a node_id or null; "first_instance" is null without instances. "path", "materials" (names,
/// null for none), "extras", and "matrix" (16 numbers, column by column) with the "weights" of morph
/// targets and the number of "vertices" follow if they are requested.
std::string encode_nodes(const Scene& scene, const NodeQuery& query, const NodePage& page);

}  // namespace sightline

// Tests: tests/integration/node_search_test.py
