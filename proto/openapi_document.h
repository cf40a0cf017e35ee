#pragma once
/// The OpenAPI document of the service: the text of proto/openapi.json.

#include <string_view>

namespace sightline {

/// OpenAPI 3.1; JSON, so that it is sent as it stands and read without a library. A test holds it
/// against the routes and the keys that the server knows.
std::string_view openapi_document();
/// Another one for another document; 32 hexadecimal digits.
std::string_view openapi_tag();

}  // namespace sightline

// Tests: tests/integration/openapi_test.py
