#pragma once
/// Headers for browsers in every answer: no content sniffing, no caching, and CORS.

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/http_message.h"
#include "server/http/request_head.h"

namespace sightline {

/// The Date header of an answer, formatted once a second. (Formatting it each time would be a tenth
/// of the user time of a trivial answer.) Thread-safe.
class DateLine {
 public:
  /// Appends the header line "Date: ..." for the present second, with its CR LF.
  void add_to(std::string& text);

 private:
  std::mutex mutex_;
  std::chrono::sys_seconds second_{};
  std::string line_;
};

/// Decides which web pages may use the server, and writes the headers that browsers need.
/// Immutable, so its functions may run on several threads. Copies share one DateLine.
class AnswerHeaders {
 public:
  /// Without origins: only pages of this machine may use the server.
  AnswerHeaders() = default;
  /// `origins`: origins whose pages may read answers, each accepted by is_origin; "*" allows all.
  explicit AnswerHeaders(std::vector<std::string> origins) : origins_(std::move(origins)) {}

  /// True for a CORS preflight from an allowed origin. It is answered before keys are checked,
  /// because a browser sends no key with it. [Fetch] 3.2.2
  bool is_preflight(const RequestHead& head) const;
  /// True if a browser sends the request on behalf of a page that is not allowed. That is a page of
  /// another site (by Sec-Fetch-Site), or one whose origin is neither this machine nor in
  /// `origins`. Without this check any web page could use a server without keys that only this
  /// machine can reach, by a form or an image. The caller refuses the request.
  bool is_strange_page(const RequestHead& head) const;
  /// True if the Host is a DNS name that is not allowed by --cors-origin. The owner of a name can
  /// point it at this machine after a page was loaded from it (DNS rebinding), so that the page's
  /// requests have the same origin. The caller refuses the request. False for addresses, names
  /// without a dot, and names below ".localhost".
  bool is_strange_name(const RequestHead& head) const;
  /// Appends header lines, each with CR LF, for the answer to `head`. Leaves out Cache-Control and
  /// Content-Security-Policy if `response` has them.
  void append_to(std::string& text, const RequestHead& head, const HttpResponse& response) const;

 private:
  bool names(std::string_view origin) const;
  bool allows(std::string_view origin) const;

  std::vector<std::string> origins_;
  std::shared_ptr<DateLine> date_ = std::make_shared<DateLine>();
};

/// True for an origin as browsers write it, without a path, such as "https://example.org" or
/// "http://localhost:3000"; and for "*".
bool is_origin(std::string_view text);

}  // namespace sightline

// Tests: tests/integration/headers_test.py
