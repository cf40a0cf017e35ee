#pragma once
/// Makes the errors of this room: short, with the place, and with little text from an untrusted
/// file.

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline::gltf {

/// Text from the file for a message: cut to at most `most` bytes at a character's border, with
/// control characters and invalid UTF-8 replaced by '?'.
std::string shortened(std::string_view text, std::size_t most = 60);

/// An error of the kind kInvalid.
inline Error invalid(std::string code, std::string message, std::string pointer = "") {
  return {ErrorKind::kInvalid, std::move(code), std::move(message), std::move(pointer)};
}

/// An error of the kind kMalformed.
inline Error malformed(std::string code, std::string message, std::string pointer = "") {
  return {ErrorKind::kMalformed, std::move(code), std::move(message), std::move(pointer)};
}

/// The error GLTF_LIMIT_<name> with the message "<what>: <value>, the limit is <limit>".
Error beyond_limit(std::string_view name, std::string_view what, std::uint64_t value,
                   std::uint64_t limit, std::string pointer = "");

}  // namespace sightline::gltf
