#include "server/sources/origin_choice.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace sightline {
namespace {

/// The code of the error, or "" if the origin could be opened.
std::string code_of(const std::string& text, const std::string& credentials = "",
                    std::map<std::string, std::string> variables = {}) {
  const auto origin =
      open_origin(text, credentials, [&](const char* name) { return variables[name]; });
  return origin ? "" : origin.error().code;
}

const std::map<std::string, std::string> kVariables{{"AWS_ACCESS_KEY_ID", "a"},
                                                    {"AWS_SECRET_ACCESS_KEY", "b"}};

TEST(OriginChoice, takes_buckets_with_credentials_of_the_environment) {
  EXPECT_EQ(code_of("s3://bucket", "", kVariables), "");
  EXPECT_EQ(code_of("s3://bucket/a/b-c/d.e/", "", kVariables), "");
  EXPECT_EQ(code_of("s3://bucket"), "ORIGIN_CREDENTIALS");
}

TEST(OriginChoice, refuses_what_is_no_origin) {
  for (const char* text : {"s3://", "s3:///a", "s3://a//b", "s3://a/../b", "s3://a b", "s3://a?b",
                           "s3://a/%2e", "http://a/b", "S3://a"}) {
    EXPECT_EQ(code_of(text, "", kVariables), "ORIGIN_INVALID") << text;
  }
  auto variables = kVariables;
  for (const char* endpoint : {"a.example", "ftp://a.example", "file:///etc"}) {
    variables["AWS_ENDPOINT_URL"] = endpoint;
    EXPECT_EQ(code_of("s3://bucket", "", variables), "ORIGIN_INVALID") << endpoint;
  }
}

TEST(OriginChoice, reads_the_first_section_of_a_file) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("sightline-credentials-" + std::to_string(::getpid()));
  const auto code_with = [&](const char* text) {
    std::ofstream(file) << text;
    return code_of("s3://bucket", file.string());
  };
  EXPECT_EQ(code_with("[default]\naws_access_key_id=a\n# x\n aws_secret_access_key = b = c \r\n"),
            "");
  EXPECT_EQ(code_with("[default]\naws_access_key_id=a\n[other]\naws_secret_access_key=b\n"),
            "ORIGIN_CREDENTIALS");
  EXPECT_EQ(code_with("aws_access_key_id a\n"), "ORIGIN_CREDENTIALS");
  EXPECT_EQ(code_with(""), "ORIGIN_CREDENTIALS");
  std::filesystem::remove(file);
}

TEST(OriginChoice, takes_a_folder_and_makes_it) {
  std::string folder = (std::filesystem::temp_directory_path() / "sightline-XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  EXPECT_EQ(code_of(folder + "/a/b"), "");
  EXPECT_TRUE(std::filesystem::is_directory(folder + "/a/b"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sightline
