#pragma once
/// How this room words its errors: short, with the place, never echoing much of a hostile file.

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::gltf {

/// Text from the file for use in a message: cut to `most` bytes (at a character's border), control
/// characters and bytes that are not UTF-8 replaced by '?'.
std::string shortened(std::string_view text, std::size_t most = 60);

inline Error invalid(std::string code, std::string message, std::string pointer = "") {
  return {ErrorKind::kInvalid, std::move(code), std::move(message), std::move(pointer)};
}

inline Error malformed(std::string code, std::string message, std::string pointer = "") {
  return {ErrorKind::kMalformed, std::move(code), std::move(message), std::move(pointer)};
}

/// "<what>: <value>, the limit is <limit>" under GLTF_LIMIT_<name>.
Error beyond_limit(std::string_view name, std::string_view what, std::uint64_t value,
                   std::uint64_t limit, std::string pointer = "");

}  // namespace sightline::gltf
