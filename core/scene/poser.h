#pragma once
/// Poser: makes the meshes of a scene in other poses, and samples the animations of its file.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/shared_column.h"
#include "core/geometry/affine.h"
#include "core/geometry/vec3.h"

namespace sightline {

struct SceneDescription;

/// What makes a change add its node to the scene.
struct AddedNode {
  std::uint32_t copy_of = 0;            ///< number of the node whose mesh it shows
  std::optional<std::uint32_t> parent;  ///< number of its parent; empty: it is a root
  std::string name = {};
  bool operator==(const AddedNode&) const = default;
};

/// A change of a node by a client. An empty member changes nothing.
struct NodeChange {
  std::uint32_t node = 0;                  ///< index in the file's "nodes", or of an added node
  std::optional<Affine> parent_from_node;  ///< replaces the node's matrix
  std::optional<bool> hidden;              ///< true: no ray meets the node or the nodes below it
  /// mask of the node, and of the nodes below it that have none of their own
  std::optional<std::uint32_t> mask;
  std::vector<double> weights = {};     ///< of all morph targets of the node; empty: no change
  std::optional<AddedNode> added = {};  ///< set: the change adds the node
  bool removed = false;                 ///< true: the node and the nodes below it are gone for good
  /// of all vertices of the node's mesh, finite; empty: no change. Copies share them.
  SharedColumn<Vec3f> positions = {};
  bool operator==(const NodeChange&) const = default;
};

/// A time of an animation of the file.
struct AnimationTime {
  std::optional<std::string> name;  ///< the first animation of this name; empty: by index
  std::uint32_t index = 0;          ///< in the file's "animations"
  double seconds = 0;               ///< finite; the first or last key beyond them
};

/// An animation of the file.
struct AnimationSummary {
  std::string name;
  double duration = 0;               ///< time of its last key in seconds
  std::vector<std::uint32_t> nodes;  ///< that it targets: indices in the file, ascending
  std::string problem;               ///< why it cannot be sampled; empty: it can
};

/// The meshes that Poser::pose made.
struct PosedMeshes {
  /// indices in SceneDescription::meshes of meshes with other content, ascending; those beyond the
  /// previous number of meshes were added
  std::vector<std::uint32_t> fresh;
  std::vector<std::uint32_t> instances;  ///< that have these meshes, or another of the old ones
  bool renumbered = false;  ///< a mesh had no instance and was removed: all may have other indices
};

/// Which nodes of a scene changed, by index in SceneDescription::nodes.
struct PoseChange {
  std::vector<bool> moved;     ///< another matrix in the world
  std::vector<bool> weighted;  ///< other weights of morph targets
};

/// Poses the meshes of one file. Thread-safe. The first call reads the file's JSON again, some 20 ns
/// for each byte, and caches what it read unless the text is large; else every call does.
class Poser {
 public:
  virtual ~Poser() = default;
  /// Makes the meshes again that the change poses, by the code of the import, so that they are those
  /// of a file in that pose. All others are shared. Errors: TRANSFORM_INVALID (a joint's matrix
  /// exceeds float32), GLTF_LIMIT_*, and those of the import for morph targets that no pose has
  /// needed before. After an error the description must not be used.
  virtual Result<PosedMeshes> pose(SceneDescription& scene, const PoseChange& change) const = 0;
  /// The transforms and weights that an animation gives to the nodes of the loaded scene that it
  /// targets, ascending by node. What it does not target of a transform is that of the file. Errors:
  /// ANIMATION_UNKNOWN with similar names, ANIMATION_INVALID.
  virtual Result<std::vector<NodeChange>> sample(const AnimationTime& time) const = 0;
  /// The animations in the order of the file. Reads one key of each sampler. Errors: GLTF_*.
  virtual Result<std::vector<AnimationSummary>> animations() const = 0;
  /// Bytes that it copied from the file and has cached.
  virtual std::uint64_t bytes() const = 0;
  /// Bytes that a call of any function may allocate, what it returns included.
  virtual std::uint64_t bytes_of_call() const = 0;
};

}  // namespace sightline

// Tests: tests/integration/poses_test.py
