#pragma once
/// What a request says its body is.

#include <initializer_list>
#include <string_view>

#include "server/http/exchange.h"

namespace sightline {

/// Whether there is a Content-Type.
bool says_media_type(const Exchange& exchange);

/// 415 MEDIA_TYPE_UNSUPPORTED, with what is accepted in Accept, unless Content-Type is one of
/// `accepted` (parameters are ignored), is left out, or is one of `tolerated`, which the answer
/// does not advertise. Returns false after it has answered.
bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated = {});

/// What `curl -d` sends when nobody tells it otherwise.
inline constexpr std::string_view kFormMediaType = "application/x-www-form-urlencoded";

/// The media type without its parameters, in any case; empty where there is none.
std::string_view media_type(const Exchange& exchange);

}  // namespace sightline
