#include "proto/openapi_document.h"
#include "server/page/docs_page.h"
#include "server/routes/page_reply.h"
#include "server/routes/routes.h"

namespace sightline {

void add_docs_routes(Router& router) {
  router.add("GET", "/openapi.json", [](Exchange& exchange) {
    reply_tagged(exchange, {openapi_document(), openapi_tag()}, "application/json");
  });
  router.add("GET", "/docs", [](Exchange& exchange) { reply_markup(exchange, docs_page()); });
  router.add("GET", "/docs/app.js", [](Exchange& exchange) {
    reply_page(exchange, docs_script(), "text/javascript; charset=utf-8");
  });
  router.add("GET", "/docs/style.css", [](Exchange& exchange) {
    reply_page(exchange, docs_style(), "text/css; charset=utf-8");
  });
}

}  // namespace sightline
