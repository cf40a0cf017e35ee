#include <string>

#include "proto/openapi_document.h"
#include "server/http/preconditions.h"
#include "server/page/docs_page.h"
#include "server/routes/routes.h"

namespace sightline {
namespace {

/// The page may run its own script and ask this server, and nothing else.
constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'";

/// The tag is weak: an answer may be compressed.
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

/// The same for everybody, so that browsers may keep it and ask whether it still holds.
void reply_page(Exchange& exchange, PageText what, std::string_view media_type) {
  reply_tagged(exchange, what, media_type);
  exchange.response.set_header("Cache-Control", "no-cache");
}

}  // namespace

void add_docs_routes(Router& router) {
  router.add("GET", "/openapi.json", [](Exchange& exchange) {
    reply_tagged(exchange, {openapi_document(), openapi_tag()}, "application/json");
  });
  router.add("GET", "/docs", [](Exchange& exchange) {
    reply_page(exchange, docs_page(), "text/html; charset=utf-8");
    exchange.response.set_header("Content-Security-Policy", kPagePolicy);
  });
  router.add("GET", "/docs/app.js", [](Exchange& exchange) {
    reply_page(exchange, docs_script(), "text/javascript; charset=utf-8");
  });
  router.add("GET", "/docs/style.css", [](Exchange& exchange) {
    reply_page(exchange, docs_style(), "text/css; charset=utf-8");
  });
}

}  // namespace sightline
