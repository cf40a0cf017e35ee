#pragma once
/// Response headers of every answer for browsers: no sniffing, no caching, and which pages may read
/// the answer.

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/http_message.h"
#include "server/http/request_head.h"

namespace sightline {

/// The Date of an answer, written once a second: it would be a tenth of what a trivial answer costs
/// outside of system calls. May be used from many threads.
class DateLine {
 public:
  void add_to(std::string& text);

 private:
  std::mutex mutex_;
  std::chrono::sys_seconds second_{};
  std::string line_;
};

class AnswerHeaders {
 public:
  AnswerHeaders() = default;
  /// `origins` are those whose pages may ask, as is_origin knows them; "*" is each.
  explicit AnswerHeaders(std::vector<std::string> origins) : origins_(std::move(origins)) {}

  /// Whether a browser asks if a page that may ask may ask this. Answered before keys are asked
  /// for: a browser shows none then. [Fetch] 3.2.2
  bool is_preflight(const RequestHead& head) const;
  /// Whether a browser asks for a page that was not named: one of another site, by Sec-Fetch-Site,
  /// or one whose origin is not this machine. Without keys that page could otherwise do what it
  /// likes: a form or an image of any site reaches a server that only this machine can reach.
  bool is_strange_page(const RequestHead& head) const;
  /// Whether the Host is a DNS name that --cors-origin does not name. The owner of such a name can
  /// point it at this machine after a page was loaded from it (DNS rebinding). The requests of that
  /// page are then of its own origin. Addresses and names without a dot are never refused.
  bool is_strange_name(const RequestHead& head) const;
  /// Appends whole lines for the answer to `head`, but none that `response` has.
  void append_to(std::string& text, const RequestHead& head, const HttpResponse& response) const;

 private:
  bool names(std::string_view origin) const;
  bool allows(std::string_view origin) const;

  std::vector<std::string> origins_;
  std::shared_ptr<DateLine> date_ = std::make_shared<DateLine>();
};

/// One "https://example.org" or "http://localhost:3000", as browsers write it, without a path. Or
/// "*".
bool is_origin(std::string_view text);

}  // namespace sightline
