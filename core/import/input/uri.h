#pragma once
/// URIs of buffers. A data URI is decoded; a relative reference becomes a path inside the scene's
/// folder.

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace sightline::gltf {

/// True if the text begins with "data:".
bool is_data_uri(std::string_view uri);

/// Returns the bytes of "data:<type>;base64,<text>". Strict [RFC4648]: the standard alphabet,
/// padded, no white space, unused bits zero. Errors: GLTF_BUFFER_INVALID.
Result<std::vector<std::byte>> decode_data_uri(std::string_view uri);

/// Returns the file that a relative reference names, as a path relative to the scene's folder.
/// Percent sequences are decoded before the checks: no scheme, no absolute path, no ".", ".." or
/// empty segment, no backslash, no control character. Errors: GLTF_URI_REFUSED.
Result<std::filesystem::path> relative_path(std::string_view uri);

}  // namespace sightline::gltf
