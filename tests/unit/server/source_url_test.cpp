#include "server/sources/source_url.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

bool matches(const char* pattern, const char* url) {
  const auto parsed = UrlPattern::parse(pattern);
  const auto address = SourceUrl::parse(url);
  EXPECT_TRUE(parsed.ok()) << pattern;
  EXPECT_TRUE(address.ok()) << url;
  return parsed.ok() && address.ok() && parsed->matches(*address);
}

TEST(UrlPattern, compares_part_by_part) {
  for (const auto& [pattern, url] : std::initializer_list<std::pair<const char*, const char*>>{
           {"https://example.org", "https://example.org"},
           {"https://example.org", "https://EXAMPLE.org:443/a/b?c#d"},
           {"https://example.org/", "https://example.org/a"},
           {"https://example.org/a/", "https://example.org/a/b/c.glb?x=1"},
           {"https://example.org/a.glb", "https://example.org/a.glb?token=2"},
           {"https://*.example.org", "https://a.b.example.org/x"},
           {"http://*:8080", "http://other.net:8080/x"},
           {"http://[::1]:*", "http://[::1]:99/x"},
           {"http://127.0.0.1", "http://0x7f.1/x"},
           {"https://example.org", "https://example.org/a%2fb"}}) {
    EXPECT_TRUE(matches(pattern, url)) << pattern << " " << url;
  }
  for (const auto& [pattern, url] : std::initializer_list<std::pair<const char*, const char*>>{
           {"https://example.org", "http://example.org"},
           {"https://example.org", "https://example.org:8443"},
           {"https://example.org", "https://example.org.evil.net/"},
           {"https://example.org", "https://evil.net/example.org"},
           {"https://*.example.org", "https://example.org/"},
           {"https://*.example.org", "https://evilexample.org/"},
           {"https://example.org/a/", "https://example.org/a"},
           {"https://example.org/a/", "https://example.org/ab/c"},
           {"https://example.org/a/", "https://example.org/a/../b"},
           {"https://example.org/a/", "https://example.org/a/%2e%2e/b"},
           {"https://example.org/a/", "https://example.org/a/..%2fb"},
           {"https://example.org/a.glb", "https://example.org/a.glb.exe"}}) {
    EXPECT_FALSE(matches(pattern, url)) << pattern << " " << url;
  }
}

TEST(UrlPattern, refuses_what_could_be_meant_otherwise) {
  for (const char* text :
       {"", "*", "example.org", "ftp://example.org", "https://", "https:///a", "https://a*.org",
        "https://*.*.org", "https://*.", "https://a:0", "https://a:x", "https://a:99999",
        "https://a?b", "https://u@a", "https://a b", "https://a/#f", "https://*.*"}) {
    EXPECT_FALSE(UrlPattern::parse(text).ok()) << text;
  }
}

TEST(SourceUrl, takes_http_and_https_without_credentials) {
  for (const std::string& text :
       {std::string("file:///etc/passwd"), std::string("ftp://example.org/a"), std::string("//a"),
        std::string("example.org/a"), std::string("https://user@example.org/"),
        std::string("https://user:word@example.org/"), std::string("http://a b/"),
        std::string("http://a\n/"), std::string("http://a/\xc3\xa9"), std::string("http://"),
        std::string("http://a:0/"), std::string("http://a:65536/"), std::string("gopher://a/"),
        std::string("http://a\0/", 10), "http://a/" + std::string(5000, 'x')}) {
    EXPECT_FALSE(SourceUrl::parse(text).ok()) << text;
  }
  const auto url = SourceUrl::parse("HTTPS://Example.ORG/a/./b/../c%20d?q");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->scheme, "https");
  EXPECT_EQ(url->host, "example.org");
  EXPECT_EQ(url->port, 443);
  EXPECT_EQ(url->path, "/a/c%20d");
}

}  // namespace
}  // namespace sightline
