#include "server/routes/page_reply.h"

#include <string>

#include "server/routes/preconditions.h"

namespace sightline {

void reply_tagged(Exchange& exchange, PageText what, std::string_view media_type) {
  const auto has = precondition_of(exchange).none_match;
  if (has && has->names(std::string(what.tag))) {
    exchange.reply_empty(304);
  } else {
    exchange.reply(200, std::string(what.text), media_type);
  }
  exchange.response.set_header("Vary", "Accept-Encoding");  // [RFC9110] 15.4.5: of a 304 too
  exchange.response.set_header("ETag", "W/\"" + std::string(what.tag) + '"');
}

void reply_page(Exchange& exchange, PageText what, std::string_view media_type) {
  reply_tagged(exchange, what, media_type);
  exchange.response.set_header("Cache-Control", "no-cache");
}

void reply_markup(Exchange& exchange, PageText what) {
  constexpr const char* kPolicy =
      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
      "require-trusted-types-for 'script'";
  reply_page(exchange, what, "text/html; charset=utf-8");
  exchange.response.set_header("Content-Security-Policy", kPolicy);
}

}  // namespace sightline
