#pragma once
/// Decodes the bodies of PATCH /v1/scenes/{id}/nodes/{node} and PATCH /v1/scenes/{id}/nodes: how
/// one node, or several, are to be changed, and which time of an animation they take.
///
///   {"translation":[0,4,0],"rotation":[0,0,0,1],"scale":[1,1,1]}
///   {"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,4,0,1],"hidden":false}
///   {"nodes":[{"node":7,"translation":[0,4,0]},{"node":9,"weights":[0.5,0]}]}
///   {"nodes":[{"node":100,"copy_of":7,"parent":0,"name":"crate"},{"node":9,"removed":true}]}
///   {"positions":[[0,0,0],[1,0,0],[0,2.5,0]]}
///   {"animation":{"name":"walk","time":0.25},"nodes":[...]}

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// A change of a node. A transform is as in glTF: `matrix` has 16 numbers, column by column; or
/// translation, rotation and scale have 3, 4 and 3. An empty member was not given.
struct NodePatch {
  std::uint32_t node = 0;  ///< the number of the node, where several are changed
  /// set: the change adds the node, as a copy of this one
  std::optional<std::uint32_t> copy_of;
  std::optional<std::uint32_t> parent;  ///< of an added node; empty: none
  std::string name;                     ///< of an added node
  std::vector<double> matrix, translation, rotation, scale, weights;
  std::optional<bool> hidden;
  std::optional<std::uint32_t> mask;
  bool removed = false;
  std::vector<float> positions;  ///< three numbers for each vertex; empty: not given

  /// True if the change has a transform.
  bool moves() const {
    return !matrix.empty() || !translation.empty() || !rotation.empty() || !scale.empty();
  }
};

/// A time of an animation: of a name, or of an index in the file.
struct AnimationPatch {
  std::optional<std::string> name;
  std::uint32_t index = 0;
  double time = 0;  ///< seconds
};

/// Changes of several nodes.
struct NodePatches {
  std::optional<AnimationPatch> animation;
  std::vector<NodePatch> nodes;  ///< empty only with an animation
};

/// Decodes a body. Errors, with a pointer: JSON_MALFORMED, TYPE_WRONG, KEY_UNKNOWN, KEY_DUPLICATE,
/// LENGTH_WRONG, and
///   KEY_MISSING          no member at all, or a parent or name without copy_of
///   KEYS_MIXED           a matrix with translation, rotation or scale; removed with any other
///   NUMBER_OUT_OF_RANGE  of weights and positions: beyond a float32
///   VALUE_UNKNOWN        removed is false
Result<NodePatch> decode_node_patch(std::string_view body);
/// Decodes a body with a list of changes, an animation or both. Errors: those of decode_node_patch;
/// KEY_DUPLICATE (a node is changed twice); KEYS_MIXED (an animation has a name and an index).
Result<NodePatches> decode_node_patches(std::string_view body);

}  // namespace sightline

// Tests: tests/integration/patch_test.py
