#include "server/http/answer_headers.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>

#include "server/http/ascii.h"
#include "server/http/ip_address.h"

namespace sightline {
namespace {

constexpr std::string_view kEvery = "*";

constexpr std::string_view kCache = "Cache-Control: no-store\r\n";
constexpr std::string_view kPolicy =
    "Content-Security-Policy: default-src 'none'; frame-ancestors 'none'\r\n";
constexpr std::string_view kFixed =
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

/// What a page may read of an answer, beside its body.
constexpr std::string_view kShown =
    "Access-Control-Expose-Headers: Allow, ETag, Location, Preference-Applied, Retry-After, "
    "WWW-Authenticate, "
    "X-Request-Id, X-Scene-Revision, X-Sightline-Unreliable, X-Sightline-Warnings, "
    "X-Sightline-Work\r\n";
constexpr std::string_view kAllowed =
    "Access-Control-Allow-Methods: GET, HEAD, POST, PUT, PATCH, DELETE\r\n"
    "Access-Control-Allow-Headers: Accept, Authorization, Content-Encoding, Content-Type, "
    "If-Match, If-None-Match, Prefer, X-Request-Id, X-Scene-Min-Revision\r\n"
    "Access-Control-Max-Age: 600\r\n";

/// Of an origin: what stands in a Host field for it.
std::string_view host_of(std::string_view origin) {
  const std::size_t scheme = origin.find("://");
  return scheme == std::string_view::npos ? std::string_view() : origin.substr(scheme + 3);
}

}  // namespace

void DateLine::add_to(std::string& text) {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const std::lock_guard hold(mutex_);
  if (now != second_ || line_.empty()) {
    // [RFC9110] 5.6.7
    // The program sets no locale, so that the names are English.
    const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
    std::tm parts{};
    std::array<char, 64> line{};
    const std::size_t length =
        std::strftime(line.data(), line.size(), "Date: %a, %d %b %Y %H:%M:%S GMT\r\n",
                      gmtime_r(&seconds, &parts));
    line_.assign(line.data(), length);
    second_ = now;
  }
  text += line_;
}

bool AnswerHeaders::names(std::string_view origin) const {
  return std::any_of(origins_.begin(), origins_.end(),
                     [&](const auto& each) { return each == kEvery || each == origin; });
}

bool AnswerHeaders::allows(std::string_view origin) const {
  return !origin.empty() && names(origin);
}

bool AnswerHeaders::is_preflight(const RequestHead& head) const {
  return head.method == "OPTIONS" && head.asks_for_method && allows(head.origin);
}

bool AnswerHeaders::is_strange_page(const RequestHead& head) const {
  if (names(head.origin)) return false;
  // Also without an origin, which an image and a link have none of.
  if (head.cross_site) return true;
  if (head.origin.empty()) return false;
  // "null" is none: a page that hides where it is from.
  const auto name = is_origin(head.origin) ? host_name(host_of(head.origin)) : std::nullopt;
  return !name || !is_local_host(*name);
}

bool AnswerHeaders::is_strange_name(const RequestHead& head) const {
  std::string name = host_name(head.host).value_or(head.host);
  if (name.ends_with('.')) name.pop_back();
  if (name.find('.') == std::string::npos || IpAddress::parse(name)) return false;
  constexpr std::string_view kOwn = ".localhost";  // [RFC6761] 6.3
  if (name.size() > kOwn.size() &&
      equals_caseless(std::string_view(name).substr(name.size() - kOwn.size()), kOwn))
    return false;
  return std::none_of(origins_.begin(), origins_.end(), [&](const std::string& origin) {
    return origin == kEvery || equals_caseless(head.host, host_of(origin));
  });
}

void AnswerHeaders::append_to(std::string& text, const RequestHead& head,
                              const HttpResponse& response) const {
  date_->add_to(text);
  text += kFixed;
  if (response.header("Cache-Control") == nullptr) text += kCache;
  if (response.header("Content-Security-Policy") == nullptr) text += kPolicy;
  if (origins_.empty()) return;
  text += "Vary: Origin\r\n";
  if (!allows(head.origin)) return;
  text.append("Access-Control-Allow-Origin: ").append(head.origin).append("\r\n");
  text += is_preflight(head) ? kAllowed : kShown;
}

bool is_origin(std::string_view text) {
  if (text == kEvery) return true;
  const std::size_t host = text.find("://");
  const std::string_view scheme = text.substr(0, std::min(host, text.size()));
  if (host == std::string_view::npos || (scheme != "http" && scheme != "https")) return false;
  const std::string_view rest = text.substr(host + 3);
  return !rest.empty() && host_name(rest) && std::all_of(rest.begin(), rest.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           std::string_view(".-:[]").find(c) != std::string_view::npos;
  });
}

}  // namespace sightline
