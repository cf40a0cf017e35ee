#include "server/routes/request_weight.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline {
namespace {

Weight weight(const char* method, const char* target, std::string_view body = "{}") {
  RequestHead head;
  head.method = method;
  head.target = target;
  return weigh_request(head, body);
}

TEST(RequestWeight, judges_the_path_and_not_the_query_part) {
  EXPECT_EQ(weight("POST", "/v1/scenes/s/rays:any"), Weight::kInline);
  EXPECT_EQ(weight("POST", "/v1/scenes/s/points:closest?/rays:any"), Weight::kShort);
  EXPECT_EQ(weight("POST", "/v1/scenes/s/rays:any", "{\"generator\":{}}"), Weight::kBulk);
}

TEST(RequestWeight, sees_what_asks_for_much_in_few_bytes) {
  const char* const closest = "/v1/scenes/town/rays:closest";
  const auto is_little = [](Weight found) {
    return found == Weight::kInline || found == Weight::kShort;
  };
  EXPECT_TRUE(
      is_little(weight("POST", closest, R"({"rays":[{"origin":[0,9,0],"direction":[0,-1,0]}]})")));
  EXPECT_EQ(weight("POST", closest, R"({"generator":{"kind":"pinhole","width":4000}})"),
            Weight::kBulk);
  EXPECT_EQ(weight("POST", closest, R"({"gener\u0061tor":{"kind":"pinhole","width":4000}})"),
            Weight::kBulk);
  EXPECT_EQ(weight("POST", closest, std::string(3000, ' ')), Weight::kBulk);
  EXPECT_TRUE(is_little(weight("GET", "/healthz", "")));
}

TEST(RequestWeight, knows_what_goes_over_a_whole_scene) {
  EXPECT_EQ(weight("GET", "/v1/scenes/s/selfcheck?rays=9"), Weight::kBulk);
  EXPECT_EQ(weight("GET", "/v1/scenes/s/nodes?x=/selfcheck"), Weight::kBulk);
}

}  // namespace
}  // namespace sightline
