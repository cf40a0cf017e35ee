#pragma once
/// The OpenAPI document of the service: the text of proto/openapi.json.

#include <string_view>

namespace sightline {

/// The document: OpenAPI 3.1 as JSON, so that it can be sent unchanged; part of the program, always
/// valid. A test compares it with the routes and the keys of the server.
std::string_view openapi_document();
/// A hash of the document, as 32 hexadecimal digits.
std::string_view openapi_tag();

}  // namespace sightline

// Tests: tests/integration/openapi_test.py
