#include "server/access/access.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Access, is_open_for_health_and_the_pages_alone) {
  for (const char* path : {"/healthz",
                           "/readyz",
                           "/readyz?x",
                           "/%72eadyz",
                           "/",
                           "/?x",
                           "/page.js",
                           "/page.css",
                           "/boot.js",
                           "/learn",
                           "/learn.js",
                           "/status",
                           "/status.js",
                           "/guide.js",
                           "/docs",
                           "/docs/app.js",
                           "/docs/style.css",
                           "/docs/documents.json.gz",
                           "/docs/README.md",
                           "/docs/guides/page.md"}) {
    EXPECT_EQ(needed_access("GET", path), Access::kOpen) << path;
    EXPECT_EQ(needed_access("HEAD", path), Access::kOpen) << path;
    EXPECT_EQ(needed_access("POST", path), Access::kRead) << path;
    EXPECT_EQ(needed_access("DELETE", path), Access::kWrite) << path;
  }
  for (const char* path :
       {"", "*", "//", "/page", "/page.js/x", "/healthz/", "//healthz", "/v1/healthz", "/metrics",
        "/openapi.json", "/docs/", "/docs/x", "/docs/app.js/x", "/docs/a/b/c.md", "/x/README.md"}) {
    EXPECT_EQ(needed_access("GET", path), Access::kRead) << path;
  }
}

TEST(Access, lets_readers_ask_and_writers_load) {
  EXPECT_EQ(needed_access("POST", "/v1/scenes/a/rays:any"), Access::kRead);
  for (const char* path : {"/v1/scenes", "/v1/scenes?wait=1", "/%76%31/scene%73"}) {
    EXPECT_EQ(needed_access("POST", path), Access::kWrite) << path;
    EXPECT_EQ(needed_access("GET", path), Access::kRead) << path;
  }
  for (const char* method : {"PUT", "DELETE", "PATCH", "BREW", "get", ""}) {
    EXPECT_EQ(needed_access(method, "/v1/scenes/a"), Access::kWrite) << method;
  }
}

RequestHead head_of(const char* method, const char* target, std::string authorization = "") {
  RequestHead head;
  head.method = method;
  head.target = target;
  head.authorization = std::move(authorization);
  return head;
}

TEST(AccessRules, let_everybody_do_everything_without_keys) {
  const AccessRules rules;
  RequestHead head = head_of("DELETE", "/v1/scenes/a", "Bearer x");
  EXPECT_FALSE(rules.admit(head));
  EXPECT_EQ(head.access, Access::kWrite);
  EXPECT_EQ(head.authorization, "");
}

TEST(AccessRules, say_who_asks_and_forget_the_key) {
  AccessRules rules;
  rules.use(*KeyRing::parse(key_line({"me", Access::kRead, key_sha256("key")})));
  RequestHead head = head_of("GET", "/v1/scenes", "Bearer key");
  EXPECT_FALSE(rules.admit(head));
  EXPECT_EQ(head.key_name, "me");
  EXPECT_EQ(head.access, Access::kRead);
  EXPECT_EQ(head.authorization, "");
  head = head_of("PUT", "/v1/scenes/a", "Bearer key");
  EXPECT_EQ(rules.admit(head)->status, 403);
  head = head_of("PUT", "/v1/scenes/a", "Bearer other");
  EXPECT_EQ(rules.admit(head)->status, 401);
  EXPECT_EQ(head.authorization, "");
  head = head_of("GET", "/readyz", "Bearer other");
  EXPECT_FALSE(rules.admit(head));
  EXPECT_EQ(head.access, Access::kOpen);
}

TEST(AccessRules, hide_keys_that_stand_where_the_log_looks) {
  AccessRules rules;
  rules.use(*KeyRing::parse(key_line({"me", Access::kRead, key_sha256("own.key")})));
  const auto admitted = [&](const char* target, const char* id, const char* authorization) {
    RequestHead head = head_of("GET", target, authorization);
    head.request_id = id;
    rules.admit(head);
    return head;
  };
  for (const char* authorization : {"", "Bearer x", "Bearer own.key"}) {
    EXPECT_EQ(admitted("/v1/scenes", "own.key", authorization).request_id, "") << authorization;
    EXPECT_EQ(admitted("/v1/scenes", "an.id", authorization).request_id, "an.id");
    EXPECT_TRUE(admitted("/v1/scenes/own.key", "", authorization).hides_path);
    EXPECT_TRUE(admitted("/v1/scenes/own%2ekey/nodes?a", "", authorization).hides_path);
    EXPECT_FALSE(admitted("/v1/scenes/an.id", "", authorization).hides_path);
  }
  EXPECT_EQ(admitted("/v1/scenes", "1own.key2", "Bearer own.key").request_id, "");
  EXPECT_TRUE(admitted("/v1/scenes/1own.key2", "", "Bearer own.key").hides_path);
  EXPECT_TRUE(rules.is_key("own.key"));
  EXPECT_FALSE(rules.is_key("other.key"));
  EXPECT_FALSE(AccessRules().is_key("own.key"));
}

TEST(AccessRules, tell_what_goes_on_when_its_key_is_one_no_more) {
  AccessRules rules;
  const auto use = [&](const std::vector<Key>& keys) {
    std::string text;
    for (const Key& key : keys) text += key_line(key) + "\n";
    rules.use(*KeyRing::parse(text));
  };
  const auto ask = [&](const char* authorization) {
    RequestHead head = head_of("GET", "/v1/scenes", authorization);
    EXPECT_FALSE(rules.admit(head));
    return head.revoked;
  };
  const Key stays{"stays", Access::kRead, key_sha256("stays")};
  const Key goes{"goes", Access::kWrite, key_sha256("goes")};
  const Key lowered{"lowered", Access::kWrite, key_sha256("lowered")};
  use({stays, goes, lowered});
  const auto first = ask("Bearer stays"), second = ask("Bearer goes"),
             third = ask("Bearer lowered");
  const Key renamed{"goes", Access::kWrite, stays.sha256};
  use({renamed, {"lowered", Access::kRead, lowered.sha256}});
  EXPECT_FALSE(first->cancelled());
  EXPECT_TRUE(second->cancelled());
  EXPECT_TRUE(third->cancelled());
  EXPECT_FALSE(ask("Bearer lowered")->cancelled());
  use({});
  EXPECT_TRUE(first->cancelled());
}

}  // namespace
}  // namespace sightline
