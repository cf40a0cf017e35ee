#include "server/answer_headers.h"

#include <algorithm>

#include "server/ip_address.h"

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
    "Access-Control-Expose-Headers: Allow, ETag, Location, Retry-After, WWW-Authenticate, "
    "X-Request-Id, X-Scene-Revision, X-Sightline-Unreliable, X-Sightline-Work\r\n";
constexpr std::string_view kAllowed =
    "Access-Control-Allow-Methods: GET, HEAD, POST, PUT, DELETE\r\n"
    "Access-Control-Allow-Headers: Accept, Authorization, Content-Type, X-Request-Id\r\n"
    "Access-Control-Max-Age: 600\r\n";

}  // namespace

bool AnswerHeaders::allows(std::string_view origin) const {
  return !origin.empty() && std::any_of(origins_.begin(), origins_.end(), [&](const auto& each) {
    return each == kEvery || each == origin;
  });
}

bool AnswerHeaders::is_preflight(const RequestHead& head) const {
  return head.method == "OPTIONS" && head.asks_for_method && allows(head.origin);
}

bool AnswerHeaders::is_strange_page(const RequestHead& head) const {
  if (head.origin.empty() || allows(head.origin)) return false;
  const std::string_view origin = head.origin;
  std::string_view host = origin.substr(std::min(origin.find("://"), origin.size()));
  if (host.empty()) return true;  // "null": a page that hides where it is from
  host.remove_prefix(3);
  if (host.starts_with('[')) return !is_local_host(std::string(host.substr(1, host.find(']') - 1)));
  return !is_local_host(std::string(host.substr(0, host.find(':'))));
}

std::string AnswerHeaders::lines(const RequestHead& head, OwnHeaders own) const {
  std::string text;
  text.reserve(kFixed.size() + kCache.size() + kPolicy.size());
  text += kFixed;
  if (!own.cache) text += kCache;
  if (!own.policy) text += kPolicy;
  if (origins_.empty()) return text;
  text += "Vary: Origin\r\n";
  if (!allows(head.origin)) return text;
  text.append("Access-Control-Allow-Origin: ").append(head.origin).append("\r\n");
  text += is_preflight(head) ? kAllowed : kShown;
  return text;
}

bool is_origin(std::string_view text) {
  if (text == kEvery) return true;
  const std::size_t host = text.find("://");
  const std::string_view scheme = text.substr(0, std::min(host, text.size()));
  if (host == std::string_view::npos || (scheme != "http" && scheme != "https")) return false;
  const std::string_view rest = text.substr(host + 3);
  return !rest.empty() && std::all_of(rest.begin(), rest.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           std::string_view(".-:[]").find(c) != std::string_view::npos;
  });
}

}  // namespace sightline
