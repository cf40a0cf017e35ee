#pragma once
/// Addresses that scenes may be fetched from, and the patterns that allow them.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

struct Curl_URL;

namespace sightline {

/// An http or https URL without credentials, taken apart once: what is compared with a pattern is
/// what the request is made of.
class SourceUrl {
 public:
  /// Errors: URL_INVALID.
  static Result<SourceUrl> parse(const std::string& text);

  std::string scheme;  ///< "http" or "https"
  std::string host;    ///< lower case; IPv6 in brackets
  int port = 0;
  std::string path;  ///< "/" at least; dot segments are resolved, percent-encoding is not decoded
  Curl_URL* handle() const { return handle_.get(); }

 private:
  struct Free {
    void operator()(Curl_URL* url) const;
  };
  std::unique_ptr<Curl_URL, Free> handle_;
};

/// SCHEME://HOST[:PORT][/PATH], compared part by part:
///   SCHEME  http or https
///   HOST    a name or an address, exactly; *.example.org any name that ends so, but not
///           example.org; * any host
///   PORT    without it the scheme's own; * any
///   PATH    ends with a slash: all paths that begin so; else exactly this one; without it all. A
///           path with an encoded slash, backslash or dot matches only patterns without PATH.
/// Queries are not compared.
class UrlPattern {
 public:
  /// Errors: URL_PATTERN_INVALID.
  static Result<UrlPattern> parse(std::string_view text);
  bool matches(const SourceUrl& url) const;

 private:
  std::string scheme_, host_, path_;
  int port_ = 0;  ///< 0: any
};

bool matches_any(const std::vector<UrlPattern>& patterns, const SourceUrl& url);

}  // namespace sightline
