#pragma once
/// Fetches the bytes of a URL that a client has chosen.

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

/// The most redirects that a fetch follows.
inline constexpr int kMostRedirects = 5;

/// What may be fetched, and how.
struct UrlRules {
  std::vector<UrlPattern> patterns;  ///< a URL that matches none is refused; empty: all are refused
  std::vector<AddressRange> addresses;      ///< non-public addresses that may be connected to
  std::chrono::milliseconds time{300'000};  ///< for the whole fetch, with redirects
  std::string agent = "sightline";          ///< value of User-Agent
};

/// Receives the bytes of a URL, on the thread of fetch_url. No function may be null.
struct UrlReceiver {
  /// called with the length, if the server states it
  std::function<void(std::uint64_t total)> expect;
  ByteSink take;                    ///< called with each piece of the answer of status 200
  std::function<bool()> cancelled;  ///< polled several times a second; true ends the fetch
};

/// Fetches a URL: sends GET requests, following redirects, until there is a 200. Blocks for at most
/// rules.time. Every redirect passes all checks again. The address is checked when connecting, so
/// no other address than the checked one is used. Uses no proxy, cookies, credentials or
/// compression. Errors: URL_INVALID, URL_NOT_ALLOWED (it, or a redirect, matches no pattern),
/// ADDRESS_REFUSED, REDIRECTS_TOO_MANY, SOURCE_UNREACHABLE, SOURCE_ANSWER (a status other than
/// 200), SOURCE_TOO_SLOW, SOURCE_TOO_LARGE, LOAD_CANCELLED, MEMORY_FULL, those of `take`. After an
/// error `take` may have got a part.
/// limit  the most bytes of the answer
Status fetch_url(SourceUrl url, const UrlRules& rules, std::uint64_t limit,
                 const UrlReceiver& receiver);

/// The error URL_NOT_ALLOWED: no pattern of the server allows the URL, or one to which it
/// redirects.
Error url_not_allowed();

}  // namespace sightline

// Tests: tests/integration/sources_test.py
