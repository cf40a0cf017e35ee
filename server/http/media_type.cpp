#include "server/http/media_type.h"

#include <algorithm>
#include <string>

#include "server/http/ascii.h"

namespace sightline {
std::string_view media_type(const Exchange& exchange) {
  if (!says_media_type(exchange)) return {};
  const std::string_view type = *exchange.head.content_type;
  return trimmed(type.substr(0, type.find(';')));
}

Error with_form_hint(const Exchange& exchange, Error error, std::string_view body) {
  const bool is_json = body.starts_with('{') && body.find("}{") == std::string_view::npos;
  const bool is_whole = body.find_first_of(std::string_view("\0\r\n", 3)) != std::string_view::npos;
  if (is_json || is_whole || !equals_caseless(media_type(exchange), kFormMediaType)) return error;
  error.message +=
      "; the Content-Type is that of a form, which curl -d sends: it removes line ends and zero "
      "bytes. Send a file with --data-binary @FILE and its Content-Type";
  return error;
}

bool says_media_type(const Exchange& exchange) { return exchange.head.content_type.has_value(); }

bool admit_media_type(Exchange& exchange, std::initializer_list<std::string_view> accepted,
                      std::initializer_list<std::string_view> tolerated) {
  if (!says_media_type(exchange)) return true;
  const std::string_view type = media_type(exchange);
  const auto is_type = [&](std::string_view each) { return equals_caseless(type, each); };
  if (std::any_of(accepted.begin(), accepted.end(), is_type)) return true;
  if (std::any_of(tolerated.begin(), tolerated.end(), is_type)) return true;
  std::string list, text;
  for (const std::string_view each : accepted) {
    list.append(list.empty() ? "" : ", ").append(each);
    text.append(text.empty() ? "" : " or ").append(each);
  }
  exchange.response.set_header("Accept", list);  // [RFC9110] 15.5.16
  exchange.reply_problem(415, "MEDIA_TYPE_UNSUPPORTED", "send Content-Type: " + text);
  return false;
}

}  // namespace sightline
