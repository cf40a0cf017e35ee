#pragma once
/// Decodes the body of POST /v1/scenes: which scene to load, and from where.
///
///   {"id":"house","source":{"path":"town/house.glb"},"options":{"scene":1}}
///   {"id":"house","source":{"url":"https://example.org/house.glb","sha256":"9f86..."}}

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace sightline {

/// A decoded body. Whether `id`, `path` and `url` are valid is for the caller to check.
struct LoadRequest {
  std::string id;                      ///< name of the scene; may be invalid
  std::string path;                    ///< empty if there is a url
  std::string url;                     ///< empty if there is a path
  std::string sha256;                  ///< 64 lower-case hexadecimal digits, or empty
  std::optional<std::uint32_t> scene;  ///< index of the chosen scene of the file
};

/// Decodes a body. Errors, with a pointer: JSON_MALFORMED, TYPE_WRONG, KEY_MISSING, KEY_UNKNOWN,
/// KEY_DUPLICATE, KEYS_MIXED (path and url), NUMBER_OUT_OF_RANGE, VALUE_UNKNOWN (an invalid hash;
/// an empty path or url).
Result<LoadRequest> decode_load_request(std::string_view body);

}  // namespace sightline
