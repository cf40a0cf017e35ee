#include "core/import/input/json_guard.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::gltf {
namespace {

std::string code(std::string_view text, const ImportLimits& limits = {}) {
  const auto size = guard_json(text, limits);
  return size ? "" : size.error().code;
}

std::string pointer(std::string_view text, const ImportLimits& limits = {}) {
  const auto size = guard_json(text, limits);
  return size ? "ok" : size.error().pointer;
}

std::string nested(std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

TEST(JsonGuard, lets_proper_text_through) {
  EXPECT_EQ(code(R"({"a":[1,2.5,-3,"x",null,true,{}],"b":{"a":1}})"), "");
}

TEST(JsonGuard, allows_nesting_up_to_the_limit_and_not_beyond) {
  ImportLimits limits;
  limits.json_depth = 8;
  EXPECT_EQ(code(nested(8), limits), "");
  EXPECT_EQ(code(nested(9), limits), "GLTF_LIMIT_JSON_DEPTH");
}

TEST(JsonGuard, survives_a_million_brackets) {
  EXPECT_EQ(code(std::string(1000000, '[')), "GLTF_LIMIT_JSON_DEPTH");
  EXPECT_EQ(code(std::string(1000000, '{')), "GLTF_JSON_INVALID");
}

TEST(JsonGuard, counts_values) {
  ImportLimits limits;
  limits.json_values = 4;
  EXPECT_EQ(code("[1,2,3]", limits), "");
  EXPECT_EQ(code("[1,2,3,4]", limits), "GLTF_LIMIT_JSON_VALUES");
  EXPECT_EQ(pointer(R"({"a":[1,2,3,4]})", limits), "/a/2");
}

TEST(JsonGuard, says_what_the_text_is_made_of) {
  const std::string_view text = R"({"a":[1,"x",[]],"b":{"c":null}})";
  const auto size = guard_json(text, {});
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(size->values, 7u);
  EXPECT_EQ(size->elements, 3u);
  EXPECT_EQ(size->members, 3u);
  EXPECT_EQ(size->arrays, 2u);
  EXPECT_EQ(size->objects, 2u);
  EXPECT_EQ(size->strings, 1u);
  EXPECT_EQ(size->bytes, text.size());
}

TEST(JsonMemory, is_refused_where_there_is_none_and_grows_with_the_text) {
  EXPECT_TRUE(try_memory(0).ok());
  const Status refused = try_memory(std::uint64_t{1} << 60);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, "GLTF_OUT_OF_MEMORY");
  EXPECT_EQ(refused.error().kind, ErrorKind::kOutOfSpace);
  const auto small = guard_json("[[],[]]", {}), large = guard_json("[[],[],[],{\"a\":\"b\"}]", {});
  EXPECT_GT(document_bytes(*small), 0u);
  EXPECT_GT(document_bytes(*large), document_bytes(*small));
}

TEST(JsonGuard, bounds_the_text) {
  ImportLimits limits;
  limits.json_bytes = 3;
  EXPECT_EQ(code("[1]", limits), "");
  EXPECT_EQ(code("[1] ", limits), "GLTF_LIMIT_JSON_BYTES");
}

TEST(JsonGuard, refuses_a_key_that_an_object_names_twice) {
  EXPECT_EQ(code(R"({"a":1,"b":{"c":1,"d":2,"c":3}})"), "GLTF_JSON_DUPLICATE_KEY");
  EXPECT_EQ(pointer(R"({"a":1,"b":[0,{"c":1,"d":2,"c":3}]})"), "/b/1");
  EXPECT_EQ(code(R"({"a":{"a":{"a":1}},"b":{"a":1}})"), "");
  EXPECT_EQ(code(R"({"a":1,"\u0061":2})"), "GLTF_JSON_DUPLICATE_KEY");
}

TEST(JsonGuard, refuses_what_is_not_json) {
  for (const char* text : {"", "{", "[1,]", "{\"a\":1,}", "// x\n{}", "[Infinity]", "[NaN]", "[01]",
                           "{} {}", "[1e999]", "[\"\xff\"]", "[\"\\ud800\"]", "{a:1}"}) {
    EXPECT_EQ(code(text), "GLTF_JSON_INVALID") << text;
  }
}

TEST(JsonGuard, says_what_is_wrong_in_its_own_words_and_where) {
  const struct {
    std::string_view text, words, pointer;
  } cases[] = {
      {"{\"a\":1,", "the text ends", ""},
      {"{\"a\":[1,2", "the text ends", "/a"},
      {"{\"a\":[{\"b\":[1,2,x]}]}", "no value", "/a/0/b"},
      {"{\"a\":{\"b\":1} \"c\":2}", "comma", ""},
      {"{\"a\":{\"b\":\xff}}", "no value", "/a/b"},
      {"{\"a\":[1 2]}", "comma", "/a"},
      {"{\"a\":1,b:2}", "key", ""},
      {"{\"a\":1,\"b\":1e999}", "float64", "/b"},
      {"{\"a\":-}", "number", "/a"},
      {"{\"a\":\"\n\"}", "control character", "/a"},
      {"{\"a\":\"\\q\"}", "escape", "/a"},
      {"{\"a\":\"\\ud800\"}", "escape", "/a"},
      {"{\"a\":\"\xff\"}", "UTF-8", "/a"},
      {"{\"a\":\"b", "no end", "/a"},
      {"{}}", "after the end", ""},
      {"\xef\xbb{}", "byte order mark", ""},
  };
  for (const auto& [text, words, pointer] : cases) {
    const auto size = guard_json(text, {});
    ASSERT_FALSE(size.ok()) << text;
    const Error& error = size.error();
    EXPECT_EQ(error.code, "GLTF_JSON_INVALID") << text;
    EXPECT_EQ(error.pointer, pointer) << text;
    EXPECT_NE(error.message.find(words), std::string::npos) << text << ": " << error.message;
    EXPECT_EQ(error.message.find("the file's JSON is broken at byte "), 0u) << error.message;
    for (const char* foreign : {"parse error", "syntax", "literal", "column", "parsing"}) {
      EXPECT_EQ(error.message.find(foreign), std::string::npos) << text << ": " << error.message;
    }
  }
}

TEST(JsonGuard, does_not_echo_the_text) {
  const auto size = guard_json("[\"" + std::string(100000, 'x') + "\xff\"]", {});
  ASSERT_FALSE(size.ok());
  EXPECT_LT(size.error().message.size(), 300u);
  EXPECT_EQ(size.error().message.find("xxxx"), std::string::npos);
}

}  // namespace
}  // namespace sightline::gltf
