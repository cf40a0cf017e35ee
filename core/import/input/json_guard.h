#pragma once
/// Checks JSON text before a document is built from it.

#include <string_view>

#include "core/base/result.h"
#include "core/import/input/json_memory.h"
#include "core/import/input/limits.h"

namespace sightline::gltf {

/// Checks syntax, UTF-8, depth, the number of values, and that no object names a key twice (glTF
/// forbids that, and readers differ in how they resolve it). One pass without recursion that builds
/// no document. Without this check, deep nesting would overflow tinygltf's stack, and a text of
/// "[],[],..." would take 30 times its size as a document. Returns the counts of the text's parts.
/// Errors: GLTF_JSON_INVALID, GLTF_JSON_DUPLICATE_KEY, GLTF_LIMIT_JSON_BYTES, _JSON_DEPTH,
/// _JSON_VALUES.
Result<JsonSize> guard_json(std::string_view text, const ImportLimits& limits);

}  // namespace sightline::gltf
