#pragma once
/// What a request says its body is.

#include <initializer_list>
#include <optional>
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

/// The media types of queries: JSON, also when it comes as a form. A browser sends forms across
/// sites without asking; that can do no harm here, because a query changes nothing and its answer
/// is not shown to the site. Returns false after it has answered.
bool admit_query_type(Exchange& exchange);

/// The media type of a query of rays or points: JSON, bytes, or lines where `takes_lines`. Nothing
/// after it has answered.
enum class QueryType { kJson, kBinary, kLines };
std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines = false);

}  // namespace sightline
