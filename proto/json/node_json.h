#pragma once
/// Decodes the bodies of PATCH /v1/scenes/{id}/nodes/{node} and PATCH /v1/scenes/{id}/nodes: how
/// one node, or several, are to be changed, and which time of an animation they take.
///
///   {"translation":[0,4,0],"rotation":[0,0,0,1],"scale":[1,1,1]}
///   {"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,4,0,1],"hidden":false}
///   {"nodes":[{"node":7,"translation":[0,4,0]},{"node":9,"weights":[0.5,0]}]}
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
  std::uint32_t node = 0;  ///< index in the file's "nodes", where several are changed
  std::vector<double> matrix, translation, rotation, scale, weights;
  std::optional<bool> hidden;
  std::optional<std::uint32_t> mask;

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

/// Decodes a body. Errors, with a pointer: JSON_MALFORMED, TYPE_WRONG, KEY_MISSING (no member at
/// all), KEY_UNKNOWN, KEY_DUPLICATE, KEYS_MIXED (a matrix with translation,
/// rotation or scale), LENGTH_WRONG, NUMBER_OUT_OF_RANGE (of weights those of a float32).
Result<NodePatch> decode_node_patch(std::string_view body);
/// Decodes a body with a list of changes, an animation or both. Errors: those of decode_node_patch;
/// KEY_DUPLICATE (a node is changed twice); KEYS_MIXED (an animation has a name and an index).
Result<NodePatches> decode_node_patches(std::string_view body);

}  // namespace sightline

// Tests: tests/integration/patch_test.py
