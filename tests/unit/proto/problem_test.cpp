#include "proto/problem.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "proto/json/json_pointer.h"

namespace sightline {
namespace {

TEST(Problem, carries_status_code_and_place) {
  const Problem problem = make_problem({ErrorKind::kInvalid, "RAY_DIRECTION_ZERO",
                                        "a direction must not be zero", "/rays/17/direction"},
                                       422, "Unprocessable Entity");
  EXPECT_EQ(
      encode_problem(problem),
      R"({"type":"urn:sightline:problem:RAY_DIRECTION_ZERO","title":"Unprocessable Entity",)"
      R"("status":422,"detail":"a direction must not be zero","code":"RAY_DIRECTION_ZERO",)"
      R"("errors":[{"pointer":"/rays/17/direction","detail":"a direction must not be zero"}]})"
      "\n");
}

TEST(Problem, leaves_out_what_is_empty_and_repairs_bad_text) {
  Problem problem;
  problem.status = 404;
  problem.title = "Not Found";
  problem.code = "SCENE_NOT_FOUND";
  problem.detail = "no scene \xff";
  const auto document = nlohmann::json::parse(encode_problem(problem));
  EXPECT_FALSE(document.contains("errors"));
  EXPECT_FALSE(document.contains("request_id"));
  EXPECT_EQ(document["detail"], "no scene \xef\xbf\xbd");
}

TEST(JsonPointer, escapes_and_cuts_names) {
  EXPECT_EQ(JsonPointer().key("a/b").key("~").index(3).text(), "/a~1b/~0/3");
  EXPECT_EQ(cut_utf8("aé", 2), "a");
  EXPECT_EQ(cut_utf8("aé", 3), "aé");
  EXPECT_LE(JsonPointer().key(std::string(1000, 'x')).text().size(), 129u);
}

}  // namespace
}  // namespace sightline
