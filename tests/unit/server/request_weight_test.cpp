#include "server/routes/request_weight.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(RequestWeight, judges_the_path_and_not_the_query_part) {
  RequestHead head;
  head.method = "POST";
  head.target = "/v1/scenes/s/rays:any";
  EXPECT_TRUE(fits_the_door(head, "{}"));
  head.target = "/v1/scenes/s/points:closest?/rays:any";
  EXPECT_FALSE(fits_the_door(head, "{}"));
}

TEST(RequestWeight, knows_what_goes_over_a_whole_scene) {
  RequestHead head;
  head.method = "GET";
  head.target = "/v1/scenes/s/selfcheck?rays=9";
  EXPECT_TRUE(walks_scene(head));
  head.target = "/v1/scenes/s/nodes?x=/selfcheck";
  EXPECT_FALSE(walks_scene(head));
}

}  // namespace
}  // namespace sightline
