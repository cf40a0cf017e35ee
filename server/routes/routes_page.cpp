#include "server/page/app_page.h"
#include "server/routes/page_reply.h"
#include "server/routes/routes.h"

namespace sightline {

void add_page_routes(Router& router) {
  router.add("GET", "/", [](Exchange& exchange) { reply_markup(exchange, app_page()); });
  router.add("GET", "/learn", [](Exchange& exchange) { reply_markup(exchange, learn_page()); });
  router.add("GET", "/learn.js", [](Exchange& exchange) {
    reply_page(exchange, learn_script(), "text/javascript; charset=utf-8");
  });
  router.add("GET", "/page.js", [](Exchange& exchange) {
    reply_page(exchange, app_script(), "text/javascript; charset=utf-8");
  });
  router.add("GET", "/page.css", [](Exchange& exchange) {
    reply_page(exchange, app_style(), "text/css; charset=utf-8");
  });
}

}  // namespace sightline
