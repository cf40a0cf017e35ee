#include "server/sources/source_url.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "server/http/ascii.h"

namespace sightline {
namespace {

constexpr std::size_t kLongest = 4096;

bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

std::string part_of(CURLU* url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, flags) != CURLUE_OK) return {};
  std::string result = text;
  curl_free(text);
  return result;
}

int default_port(std::string_view scheme) { return scheme == "https" ? 443 : 80; }

bool parse_port(std::string_view text, int& port) {
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && last == text.data() + text.size() && port > 0 && port < 65536;
}

/// What a server behind might take for a separator after all.
bool has_hidden_separator(const std::string& path) {
  const std::string small = lower_case(path);
  constexpr std::array<const char*, 4> kHidden{"\\", "%2f", "%5c", "%2e"};
  return std::any_of(kHidden.begin(), kHidden.end(),
                     [&](const char* hidden) { return small.find(hidden) != std::string::npos; });
}

}  // namespace

void SourceUrl::Free::operator()(Curl_URL* url) const { curl_url_cleanup(url); }

Result<SourceUrl> SourceUrl::parse(const std::string& text) {
  const auto invalid = [](std::string message) {
    return Error{ErrorKind::kInvalid, "URL_INVALID", std::move(message), ""};
  };
  if (text.size() > kLongest) return invalid("the url is longer than 4096 bytes");
  if (!is_plain(text)) return invalid("the url has a blank, a control character or no ASCII");
  SourceUrl url;
  url.handle_.reset(curl_url());
  if (!url.handle_) return invalid("the url could not be read");
  const CURLUcode code =
      curl_url_set(url.handle(), CURLUPART_URL, text.c_str(), CURLU_DISALLOW_USER);
  if (code == CURLUE_USER_NOT_ALLOWED) return invalid("the url must not hold credentials");
  if (code != CURLUE_OK) return invalid("this is no http or https url");
  url.scheme = part_of(url.handle(), CURLUPART_SCHEME);
  if (url.scheme != "http" && url.scheme != "https") {
    return invalid("this is no http or https url");
  }
  url.host = lower_case(part_of(url.handle(), CURLUPART_HOST));
  if (!parse_port(part_of(url.handle(), CURLUPART_PORT, CURLU_DEFAULT_PORT), url.port) ||
      url.host.empty()) {
    return invalid("the url has no host, or a port that is none");
  }
  url.path = part_of(url.handle(), CURLUPART_PATH);
  return url;
}

Result<UrlPattern> UrlPattern::parse(std::string_view text) {
  const Error invalid{ErrorKind::kInvalid, "URL_PATTERN_INVALID",
                      "'" + std::string(text) +
                          "' is no pattern: write SCHEME://HOST[:PORT][/PATH], as in "
                          "https://*.example.org/scenes/",
                      ""};
  UrlPattern pattern;
  const std::size_t colon = text.find("://");
  if (colon == std::string_view::npos || !is_plain(text)) return invalid;
  if (text.find_first_of("?#@\\") != std::string_view::npos) return invalid;
  pattern.scheme_ = lower_case(text.substr(0, colon));
  if (pattern.scheme_ != "http" && pattern.scheme_ != "https") return invalid;
  text.remove_prefix(colon + 3);
  const std::size_t slash = std::min(text.find('/'), text.size());
  pattern.path_ = text.substr(slash);
  std::string_view authority = text.substr(0, slash);
  // The colons of an IPv6 address stand in brackets.
  const std::size_t bracket = authority.rfind(']');
  const std::size_t port = authority.find(':', bracket == std::string_view::npos ? 0 : bracket);
  pattern.port_ = default_port(pattern.scheme_);
  if (port != std::string_view::npos) {
    const std::string_view number = authority.substr(port + 1);
    if (number == "*") {
      pattern.port_ = 0;
    } else if (!parse_port(number, pattern.port_)) {
      return invalid;
    }
  }
  pattern.host_ = lower_case(authority.substr(0, port));
  std::string_view name = pattern.host_;
  if (name.starts_with("*.")) name.remove_prefix(2);
  if (name.empty() || (name != "*" && name.find('*') != std::string_view::npos)) return invalid;
  if (name == "*" && pattern.host_ != "*") return invalid;
  return pattern;
}

bool UrlPattern::matches(const SourceUrl& url) const {
  if (url.scheme != scheme_ || (port_ != 0 && url.port != port_)) return false;
  if (host_.starts_with("*.")) {
    const std::string_view ending = std::string_view(host_).substr(1);
    if (url.host.size() <= ending.size() || !url.host.ends_with(ending)) return false;
  } else if (host_ != "*" && host_ != url.host) {
    return false;
  }
  if (path_.empty()) return true;
  if (has_hidden_separator(url.path)) return false;
  return path_.ends_with('/') ? url.path.starts_with(path_) : url.path == path_;
}

bool matches_any(const std::vector<UrlPattern>& patterns, const SourceUrl& url) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const UrlPattern& pattern) { return pattern.matches(url); });
}

}  // namespace sightline
