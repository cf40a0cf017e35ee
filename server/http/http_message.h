#pragma once
/// The answer to a request, as handlers make it.

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {

struct HttpResponse {
  using Send = std::function<bool(std::string_view)>;

  int status = 0;  ///< 0: nothing was answered yet
  std::string body{};
  std::string_view content_type{};  ///< a literal; empty: no such header
  std::vector<std::pair<std::string, std::string>> headers{};
  /// Not null: called again and again after the header is sent, each time with a function that sends
  /// a piece of the body. False ends the body.
  std::function<bool(const Send& send)> stream{};

  /// Adds a header; earlier ones of this name stay.
  void set_header(std::string_view name, std::string value) {
    headers.emplace_back(name, std::move(value));
  }
  /// The value of the first header of this name, spelled like this; null where there is none.
  const std::string* header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
      if (key == name) return &value;
    }
    return nullptr;
  }
};

}  // namespace sightline
