#include "proto/json/load_json.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(LoadJson, reads_a_path_or_a_url_with_its_hash_and_scene) {
  const std::string hash(64, 'a');
  const auto by_path = decode_load_request(R"({"id":"a","source":{"path":"x/y.glb"}})");
  ASSERT_TRUE(by_path.ok());
  EXPECT_EQ(by_path->path, "x/y.glb");
  EXPECT_FALSE(by_path->scene);
  const auto by_url = decode_load_request(R"({"options":{"scene":3},"source":{"sha256":")" + hash +
                                          R"(","url":"http://a"},"id":"b"})");
  ASSERT_TRUE(by_url.ok());
  EXPECT_EQ(by_url->url, "http://a");
  EXPECT_EQ(by_url->sha256, hash);
  EXPECT_EQ(by_url->scene, 3u);
}

TEST(LoadJson, names_every_fault_with_its_place) {
  const auto expect = [](const char* body, const char* code, const char* pointer) {
    const auto request = decode_load_request(body);
    ASSERT_FALSE(request.ok()) << body;
    EXPECT_EQ(request.error().code, code) << body;
    EXPECT_EQ(request.error().pointer, pointer) << body;
  };
  expect("", "JSON_MALFORMED", "");
  expect("{", "JSON_MALFORMED", "");
  expect(R"({"id":"a"} x)", "JSON_MALFORMED", "");
  expect("[]", "TYPE_WRONG", "");
  expect("3", "TYPE_WRONG", "");
  expect("{}", "KEY_MISSING", "");
  expect(R"({"id":1,"source":{"path":"x"}})", "TYPE_WRONG", "/id");
  expect(R"({"id":"a","source":7})", "TYPE_WRONG", "/source");
  expect(R"({"id":"a","source":{}})", "KEY_MISSING", "/source");
  expect(R"({"id":"a","source":{"path":""}})", "VALUE_UNKNOWN", "/source/path");
  expect(R"({"id":"a","source":{"path":null}})", "TYPE_WRONG", "/source/path");
  expect(R"({"id":"a","source":{"path":"x","url":"y"}})", "KEYS_MIXED", "/source/url");
  expect(R"({"id":"a","source":{"path":"x","file":"y"}})", "KEY_UNKNOWN", "/source/file");
  expect(R"({"id":"a","source":{"path":"x","sha256":"AB"}})", "VALUE_UNKNOWN", "/source/sha256");
  expect(R"({"id":"a","id":"b","source":{"path":"x"}})", "KEY_DUPLICATE", "/id");
  expect(R"({"id":"a","source":{"path":"x"},"colour":1})", "KEY_UNKNOWN", "/colour");
  expect(R"({"id":"a","source":{"path":"x"},"options":[]})", "TYPE_WRONG", "/options");
  expect(R"({"id":"a","source":{"path":"x"},"options":{"scene":-1}})", "NUMBER_OUT_OF_RANGE",
         "/options/scene");
  expect(R"({"id":"a","source":{"path":"x"},"options":{"scene":1.5}})", "NUMBER_OUT_OF_RANGE",
         "/options/scene");
  expect(R"({"id":"a","source":{"path":"x"},"options":{"scene":4294967296}})",
         "NUMBER_OUT_OF_RANGE", "/options/scene");
  expect(R"({"id":"a","source":{"path":"x"},"options":{"tree":1}})", "KEY_UNKNOWN",
         "/options/tree");
}

}  // namespace
}  // namespace sightline
