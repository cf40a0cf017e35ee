#pragma once
/// Checks the media type of request bodies.

#include <initializer_list>
#include <string_view>

#include "server/http/exchange.h"

namespace sightline {

/// True if the request has a Content-Type.
bool says_media_type(const Exchange& exchange);

/// Checks that the Content-Type (without parameters) is in `accepted` or `tolerated`, or missing.
/// Otherwise answers 415 MEDIA_TYPE_UNSUPPORTED, with `accepted` in the header Accept, and returns
/// false. The lists are in lower case; the client may use any case.
bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated = {});

/// The Content-Type that `curl -d` sends by default.
inline constexpr std::string_view kFormMediaType = "application/x-www-form-urlencoded";

/// The error of a request whose body could not be read, with a hint if the client sent it as a form:
/// `curl -d` removes line ends and zero bytes. `body` is its beginning, as far as it is known; the
/// hint is left out if it cannot have lost anything that matters: JSON in one piece.
Error with_form_hint(const Exchange& exchange, Error error, std::string_view body);

/// The media type of the body without its parameters, as the client spelled it; empty if there is
/// none. Valid as long as `exchange.head`.
std::string_view media_type(const Exchange& exchange);

}  // namespace sightline

// Tests: tests/integration/errors_test.py
