#pragma once
/// Gets the bytes behind a URL that somebody else chose.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/http/ip_address.h"
#include "server/sources/scene_root.h"
#include "server/sources/source_url.h"

namespace sightline {

inline constexpr int kMostRedirects = 5;

struct UrlRules {
  std::vector<UrlPattern> patterns;         ///< a URL that matches none is refused; empty: all are
  std::vector<AddressRange> addresses;      ///< that may be reached though they are not public
  std::chrono::milliseconds time{300'000};  ///< for everything, redirects included
  std::string agent = "sightline";          ///< User-Agent
};

struct UrlReceiver {
  std::function<void(std::uint64_t total)> expect;  ///< told the length, if the server says it
  ByteSink take;
  std::function<bool()> cancelled;  ///< asked several times a second
};

/// One GET after the other, until there is a 200. Every redirect passes all checks again. The
/// address is checked at the moment of connecting: what was resolved and checked is what is
/// connected to. No proxy, no cookies, no credentials, no compression.
/// Errors: URL_INVALID, URL_NOT_ALLOWED (matches no pattern; also of a redirect), ADDRESS_REFUSED,
/// REDIRECTS_TOO_MANY, SOURCE_UNREACHABLE, SOURCE_ANSWER (not a 200), SOURCE_TOO_SLOW,
/// SOURCE_TOO_LARGE, LOAD_CANCELLED, those of `take`.
Status fetch_url(SourceUrl url, const UrlRules& rules, std::uint64_t limit,
                 const UrlReceiver& receiver);

/// URL_NOT_ALLOWED: no pattern of the server allows a URL, or one that it was redirected to.
Error url_not_allowed();

}  // namespace sightline
