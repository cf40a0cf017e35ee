#include "server/request_framing.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>

namespace sightline {
namespace {

/// Digits alone: no sign, no list, no blank.
bool is_length(const std::string& text) {
  std::uint64_t length = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, length);
  return error == std::errc() && last == end;
}

bool is_chunked(const std::string& text) {
  constexpr std::string_view kChunked = "chunked";
  return std::equal(text.begin(), text.end(), kChunked.begin(), kChunked.end(), [](char a, char b) {
    return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
  });
}

}  // namespace

std::optional<FramingFault> find_framing_fault(const httplib::Request& request) {
  constexpr const char* kFraming = "FRAMING_AMBIGUOUS";
  const std::size_t hosts = request.get_header_value_count("Host");
  if (hosts > 1 || (hosts == 0 && request.version != "HTTP/1.0")) {
    return FramingFault{"HOST_INVALID", "a request needs exactly one Host header"};
  }
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  const std::size_t encodings = request.get_header_value_count("Transfer-Encoding");
  if (lengths + encodings > 1) {
    return FramingFault{kFraming, "send one Content-Length or one Transfer-Encoding, and not both"};
  }
  if (lengths == 1 && !is_length(request.get_header_value("Content-Length"))) {
    return FramingFault{kFraming, "Content-Length is not a number of bytes"};
  }
  if (encodings == 1 && !is_chunked(request.get_header_value("Transfer-Encoding"))) {
    return FramingFault{kFraming, "the only Transfer-Encoding here is chunked"};
  }
  return std::nullopt;
}

}  // namespace sightline
