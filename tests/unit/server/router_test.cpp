#include "server/http/router.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

std::vector<std::string> segments(std::string_view target) {
  std::vector<std::string> path;
  if (!split_path(target, path)) return {"no path"};
  return path;
}

TEST(Router, splits_before_it_decodes) {
  using Path = std::vector<std::string>;
  EXPECT_EQ(segments("/"), Path{""});
  EXPECT_EQ(segments("/v1/scenes"), (Path{"v1", "scenes"}));
  EXPECT_EQ(segments("/v1/scenes/"), (Path{"v1", "scenes", ""}));
  EXPECT_EQ(segments("/a%2Fb/c%20d?x=/y"), (Path{"a/b", "c d"}));
  EXPECT_EQ(segments("/%00"), Path{std::string(1, '\0')});
  for (const char* bad : {"", "x", "*", "http://host/", "/%", "/%4", "/%zz", "/a%2/b"}) {
    EXPECT_EQ(segments(bad), Path{"no path"}) << bad;
  }
}

struct Asked {
  int status;
  std::string code_or_handler;
  std::string allow;
};

Asked ask(const std::string& method, const std::string& target) {
  Router router;
  for (const char* route : {"GET /a", "PUT /a/{id}", "GET /a/{id}", "POST /a/{id}/x:y"}) {
    const std::string text = route;
    const std::size_t space = text.find(' ');
    router.add(text.substr(0, space), text.substr(space + 1), [text](Exchange& exchange) {
      exchange.reply(200, text + " " + exchange.scene_id, "x");
    });
  }
  RequestHead request;
  request.method = method;
  request.target = target;
  HttpResponse response;
  Exchange exchange{request, response, nullptr, nullptr, nullptr, "id"};
  router.dispatch(exchange);
  std::string said = response.body;
  for (const char* code : {"ROUTE_NOT_FOUND", "METHOD_NOT_ALLOWED"}) {
    if (said.find(code) != std::string::npos) said = code;
  }
  const std::string* allow = response.header("Allow");
  return {response.status, said, allow == nullptr ? "" : *allow};
}

TEST(Router, finds_the_handler_and_the_name_in_the_path) {
  EXPECT_EQ(ask("GET", "/a").code_or_handler, "GET /a ");
  EXPECT_EQ(ask("GET", "/a/b%20c").code_or_handler, "GET /a/{id} b c");
  EXPECT_EQ(ask("PUT", "/a/b?q").status, 422);  // a route refuses parameters that it does not read
  EXPECT_EQ(ask("POST", "/a/b/x:y").code_or_handler, "POST /a/{id}/x:y b");
  EXPECT_EQ(ask("HEAD", "/a").code_or_handler, "GET /a ");
}

TEST(Router, says_what_is_missing) {
  for (const char* target : {"/", "/b", "/a/", "/a/b/x:z", "/a/b/x:y/", "/a//x:y", "/%zz"}) {
    EXPECT_EQ(ask("GET", target).status, 404) << target;
  }
  EXPECT_EQ(ask("DELETE", "/a/b").status, 405);
  EXPECT_EQ(ask("DELETE", "/a/b").allow, "PUT, GET, HEAD, OPTIONS");
  EXPECT_EQ(ask("get", "/a").status, 405);
  EXPECT_EQ(ask("OPTIONS", "/a/b/x:y").status, 204);
  EXPECT_EQ(ask("OPTIONS", "/b").status, 404);
}

}  // namespace
}  // namespace sightline
