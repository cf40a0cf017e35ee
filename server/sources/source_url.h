#pragma once
/// SourceUrl: the URL of a scene. UrlPattern: a pattern that allows URLs.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

struct Curl_URL;

namespace sightline {

/// An http or https URL without credentials, parsed once: the parts that are compared with patterns
/// are those that the request is made of.
class SourceUrl {
 public:
  /// Parses a URL of at most 4096 bytes. Errors: URL_INVALID.
  static Result<SourceUrl> parse(const std::string& text);

  std::string scheme;  ///< "http" or "https"
  std::string host;    ///< lower case; IPv6 in brackets
  int port = 0;
  std::string path;  ///< at least "/"; dot segments are resolved, percent-encoding is not decoded
  /// The parsed URL for libcurl; valid while this object lives.
  Curl_URL* handle() const { return handle_.get(); }

 private:
  struct Free {
    void operator()(Curl_URL* url) const;
  };
  std::unique_ptr<Curl_URL, Free> handle_;
};

/// A pattern SCHEME://HOST[:PORT][/PATH], compared part by part:
///   SCHEME  http or https
///   HOST    a name or an address, exactly; *.example.org: names that end so, but not example.org;
///           *: any host
///   PORT    absent: the scheme's default; *: any
///   PATH    with a slash at its end: paths that begin so; otherwise: exactly this path; absent:
///           any. A path with an encoded slash, backslash or dot matches only patterns without
///           PATH.
/// Queries are not compared.
class UrlPattern {
 public:
  /// Parses a pattern. Errors: URL_PATTERN_INVALID.
  static Result<UrlPattern> parse(std::string_view text);
  /// True if all parts of the pattern match.
  bool matches(const SourceUrl& url) const;

 private:
  std::string scheme_, host_, path_;
  int port_ = 0;  ///< 0: any port
};

/// True if one of the patterns matches; false for an empty list.
bool matches_any(const std::vector<UrlPattern>& patterns, const SourceUrl& url);

}  // namespace sightline
