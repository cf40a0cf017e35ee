#pragma once
/// Checks JSON text before anything is built from it.

#include <string_view>

#include "core/base/result.h"
#include "core/import/input/json_memory.h"
#include "core/import/input/limits.h"

namespace sightline::gltf {

/// One pass without recursion and without a document: syntax, UTF-8, depth, number of values, and
/// that no object names a key twice (which glTF forbids, and which readers resolve differently).
/// Deeply nested text overflows tinygltf's stack; a text of "[],[],..." takes 30 times its size as
/// a document. Returns what the text is made of.
/// Errors: GLTF_JSON_INVALID, GLTF_JSON_DUPLICATE_KEY, GLTF_LIMIT_JSON_BYTES, _JSON_DEPTH,
/// _JSON_VALUES.
Result<JsonSize> guard_json(std::string_view text, const ImportLimits& limits);

}  // namespace sightline::gltf
