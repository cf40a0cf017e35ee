#pragma once
/// The body of PATCH /v1/scenes/{id}/nodes/{node}: what is to be different about a node.
///
///   {"translation":[0,4,0],"rotation":[0,0,0,1],"scale":[1,1,1]}
///   {"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,4,0,1],"hidden":false}

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// A node's transform as in glTF: a matrix of 16 numbers column by column, or 3, 4 and 3 of the
/// others. An empty member was not given.
struct NodePatch {
  std::vector<double> matrix, translation, rotation, scale;
  std::optional<bool> hidden;
  std::optional<std::uint32_t> mask;

  bool moves() const {
    return !matrix.empty() || !translation.empty() || !rotation.empty() || !scale.empty();
  }
};

/// Errors, with a pointer: JSON_MALFORMED, TYPE_WRONG, KEY_MISSING (nothing is to be different),
/// KEY_UNKNOWN, KEY_DUPLICATE, KEYS_MIXED (a matrix and others), LENGTH_WRONG,
/// NUMBER_OUT_OF_RANGE.
Result<NodePatch> decode_node_patch(std::string_view body);

}  // namespace sightline

// Tests: tests/integration/patch_test.py
