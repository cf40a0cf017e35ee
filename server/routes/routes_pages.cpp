#include <algorithm>
#include <string>

#include "proto/openapi_document.h"
#include "server/page/pages.h"
#include "server/routes/preconditions.h"
#include "server/routes/routes.h"

namespace sightline {
namespace {

constexpr const char *kScript = "text/javascript; charset=utf-8",
                     *kStyle = "text/css; charset=utf-8";

/// 200, or 304 where If-None-Match names the text. The tag is weak: an answer may be compressed.
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

/// reply_tagged for a part of a page: browsers may cache it and ask whether it still holds.
void reply_page(Exchange& exchange, PageText what, std::string_view media_type) {
  reply_tagged(exchange, what, media_type);
  exchange.response.set_header("Cache-Control", "no-cache");
}

/// reply_page for HTML, with the policy that the page may run its own script and ask this server,
/// and nothing else.
void reply_markup(Exchange& exchange, PageText what) {
  constexpr const char* kPolicy =
      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
      "require-trusted-types-for 'script'";
  reply_page(exchange, what, "text/html; charset=utf-8");
  exchange.response.set_header("Content-Security-Policy", kPolicy);
}

auto page(PageText (&text)()) {
  return [&text](Exchange& exchange) { reply_markup(exchange, text()); };
}
auto part(PageText (&text)(), const char* media_type) {
  return [&text, media_type](Exchange& exchange) { reply_page(exchange, text(), media_type); };
}

/// Answers with the file of this name. Precondition: it is one of page_parts().
Router::Handler file(std::string_view name) {
  const auto parts = page_parts();
  const PagePart& found = *std::find_if(parts.begin(), parts.end(),
                                        [&](const PagePart& each) { return each.name == name; });
  return [&found](Exchange& exchange) {
    if (found.name.ends_with(".html")) return reply_markup(exchange, found.what);
    reply_page(exchange, found.what, found.media_type);
  };
}

/// A shell; its script shows the document that the address names.
Router::Handler shell(std::string_view document) {
  return file(document.find('/') == document.npos ? "guide.html" : "guide_below.html");
}

}  // namespace

void add_page_routes(Router& router) {
  router.add("GET", "/", file("index.html"));
  router.add("GET", "/boot.js", file("boot.js"));
  router.add("GET", "/page.js", file("page.js"));
  router.add("GET", "/page.css", file("page.css"));
  router.add("GET", "/learn", file("learn.html"));
  router.add("GET", "/learn.js", file("learn.js"));
  router.add("GET", "/status", file("status.html"));
  router.add("GET", "/status.js", file("status.js"));
  router.add("GET", "/guide.js", file("guide.js"));
  router.add("GET", "/docs", page(docs_page));
  router.add("GET", "/docs/app.js", part(docs_script, kScript));
  router.add("GET", "/docs/style.css", part(docs_style, kStyle));
  router.add("GET", "/openapi.json", [](Exchange& exchange) {
    reply_tagged(exchange, {openapi_document(), openapi_tag()}, "application/json");
  });
  router.add("GET", "/docs/documents.json.gz", file("documents.json.gz"));
  router.add("GET", "/docs/README.md", shell("README.md"));
  for (const std::string_view document : page_documents()) {
    const std::string path = std::string("/docs/").append(document);
    if (document != "README.md") router.add("GET", path, shell(document));
  }
}

}  // namespace sightline
