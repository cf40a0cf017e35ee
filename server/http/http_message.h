#pragma once
/// HttpResponse: the answer to a request, as handlers make it.

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {

/// Filled by a handler through Exchange, and written by HttpServer after the handler has returned.
struct HttpResponse {
  /// Sends a piece of the body; false if the client is gone.
  using Send = std::function<bool(std::string_view)>;

  int status = 0;  ///< 0: not answered yet
  std::string body{};
  std::string_view content_type{};  ///< a literal; empty: no Content-Type
  std::vector<std::pair<std::string, std::string>> headers{};
  /// If not null, the body is a stream. Called repeatedly after the header is sent, each time with
  /// a function that sends a piece of the body; a result of false ends the body.
  std::function<bool(const Send& send)> stream{};

  /// Adds a header. Earlier headers with this name stay.
  void set_header(std::string_view name, std::string value) {
    headers.emplace_back(name, std::move(value));
  }
  /// The value of the first header whose name is spelled so, in the same case; null if there is
  /// none. Valid until the next set_header.
  const std::string* header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
      if (key == name) return &value;
    }
    return nullptr;
  }
};

}  // namespace sightline

// Tests: tests/unit/server/http_server_test.cpp
