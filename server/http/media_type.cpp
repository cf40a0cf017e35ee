#include "server/http/media_type.h"

#include <algorithm>
#include <string>

#include "proto/hit_lines.h"
#include "proto/ray_binary.h"
#include "server/http/ascii.h"

namespace sightline {
namespace {

/// The media type without its parameters, in lower case.
std::string media_type(const Exchange& exchange) {
  if (!says_media_type(exchange)) return {};
  const std::string_view type = *exchange.head.content_type;
  return lower_case(trimmed(type.substr(0, type.find(';'))));
}

}  // namespace

bool says_media_type(const Exchange& exchange) { return exchange.head.content_type.has_value(); }

bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated) {
  if (!says_media_type(exchange)) return true;
  const std::string type = media_type(exchange);
  std::string list, text;
  for (const std::string_view each : accepted) {
    if (type == each) return true;
    list.append(list.empty() ? "" : ", ").append(each);
    text.append(text.empty() ? "" : " or ").append(each);
  }
  if (std::find(tolerated.begin(), tolerated.end(), type) != tolerated.end()) return true;
  exchange.response.set_header("Accept", list);  // [RFC9110] 15.5.16
  exchange.reply_problem(415, "MEDIA_TYPE_UNSUPPORTED", "send Content-Type: " + text);
  return false;
}

bool admit_query_type(Exchange& exchange) {
  return admit_media_type(exchange, {"application/json"}, {kFormMediaType});
}

std::optional<QueryType> admit_rays_type(Exchange& exchange, bool takes_lines) {
  const bool good =
      takes_lines
          ? admit_media_type(exchange, {"application/json", kLinesMediaType, kBinaryMediaType},
                             {kFormMediaType})
          : admit_media_type(exchange, {"application/json", kBinaryMediaType}, {kFormMediaType});
  if (!good) return std::nullopt;
  const std::string type = media_type(exchange);
  if (type == kBinaryMediaType) return QueryType::kBinary;
  return type == kLinesMediaType ? QueryType::kLines : QueryType::kJson;
}

}  // namespace sightline
