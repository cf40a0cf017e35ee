#include "core/import/input/uri.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::gltf {
namespace {

std::string decoded(const std::string& base64) {
  const auto bytes = decode_data_uri("data:application/octet-stream;base64," + base64);
  if (!bytes) return "error " + bytes.error().code;
  return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

std::string path(std::string_view uri) {
  const auto relative = relative_path(uri);
  return relative ? relative->string() : relative.error().code;
}

TEST(DataUri, decodes_every_length_of_the_last_group) {
  EXPECT_EQ(decoded(""), "");
  EXPECT_EQ(decoded("Zg=="), "f");
  EXPECT_EQ(decoded("Zm8="), "fo");
  EXPECT_EQ(decoded("Zm9v"), "foo");
  EXPECT_EQ(decoded("Zm9vYg=="), "foob");
  EXPECT_EQ(decoded("+/+/"), "\xfb\xff\xbf");
}

TEST(DataUri, is_strict) {
  for (const char* text : {"Z", "Zg", "Zg=", "Zm9v\n", "Zm 9",
                           "Z===", "====", "Zh==", "Zm9=", "Zg==Zg==", "-_-_", "Zm9v%3D"}) {
    EXPECT_EQ(decoded(text), "error GLTF_BUFFER_INVALID") << text;
  }
}

TEST(DataUri, needs_the_base64_marker_before_the_comma) {
  EXPECT_FALSE(decode_data_uri("data:application/octet-stream,abc").ok());
  EXPECT_FALSE(decode_data_uri("data:,x;base64,Zm9v").ok());
  EXPECT_TRUE(decode_data_uri("data:;base64,Zm9v").ok());
}

TEST(RelativePath, decodes_percent_sequences) {
  EXPECT_EQ(path("a%20b.bin"), "a b.bin");
  EXPECT_EQ(path("folder/a.bin"), "folder/a.bin");
  EXPECT_EQ(path("%C3%A9.bin"), "\xc3\xa9.bin");
  EXPECT_EQ(path("a..b"), "a..b");
  EXPECT_EQ(path("...bin"), "...bin");
}

TEST(RelativePath, never_leaves_the_folder) {
  for (const char* uri :
       {"..",   ".",        "../a",  "a/../b", "%2e%2e/a", "..%2fa", "a/%2E%2E/b", "/a",
        "%2fa", "//host/a", "a//b",  "a/",     "./a",      "",       "http://h/a", "file:///a",
        "C:/a", "c:a",      "x+y:a", "a\\b",   "a%5cb",    "a%00b",  "a%0ab",      "a%7f",
        "a%",   "a%4",      "a%zz",  "a?b",    "a#b"}) {
    EXPECT_EQ(path(uri), "GLTF_URI_REFUSED") << uri;
  }
}

}  // namespace
}  // namespace sightline::gltf
