#include "core/import/input/uri.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <string>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

constexpr std::string_view kMarker = ";base64,";

/// 64 for a character that is not of the alphabet.
constexpr std::array<std::uint8_t, 256> kDigit = [] {
  std::array<std::uint8_t, 256> digit = {};
  digit.fill(64);
  const std::string_view alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < alphabet.size(); ++i) {
    digit[static_cast<unsigned char>(alphabet[i])] = static_cast<std::uint8_t>(i);
  }
  return digit;
}();

Error bad_data(const char* what) {
  return invalid("GLTF_BUFFER_INVALID", std::string("data URI: ") + what);
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// "letter (letter | digit | + - .)* :" [RFC3986] 3.1.
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  if (std::isalpha(static_cast<unsigned char>(uri[0])) == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.';
  });
}

}  // namespace

bool is_data_uri(std::string_view uri) { return uri.rfind("data:", 0) == 0; }

Result<std::vector<std::byte>> decode_data_uri(std::string_view uri) {
  const std::size_t marker = uri.find(kMarker);
  if (marker == std::string_view::npos || uri.find(',') < marker) return bad_data("not base64");
  std::string_view text = uri.substr(marker + kMarker.size());
  if (text.size() % 4 != 0) return bad_data("the length of the base64 text is not a multiple of 4");
  std::size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
  text.remove_suffix(padding);

  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t group = 0;
  std::size_t digits = 0;
  for (char c : text) {
    const std::uint32_t digit = kDigit[static_cast<unsigned char>(c)];
    if (digit == 64) return bad_data("a character that is not of the base64 alphabet");
    group = group << 6 | digit;
    if (++digits == 4) {
      for (int shift = 16; shift >= 0; shift -= 8) {
        bytes.push_back(static_cast<std::byte>(group >> shift & 0xff));
      }
      group = 0;
      digits = 0;
    }
  }
  // Two digits carry one byte and 4 spare bits, three carry two bytes and 2 spare bits.
  if (digits == 2) {
    if ((group & 0xf) != 0) return bad_data("bits set in the padding");
    bytes.push_back(static_cast<std::byte>(group >> 4));
  } else if (digits == 3) {
    if ((group & 0x3) != 0) return bad_data("bits set in the padding");
    bytes.push_back(static_cast<std::byte>(group >> 10 & 0xff));
    bytes.push_back(static_cast<std::byte>(group >> 2 & 0xff));
  }
  return bytes;
}

Result<std::filesystem::path> relative_path(std::string_view uri) {
  const auto refused = [&](const char* why) {
    return invalid("GLTF_URI_REFUSED", "buffer URI \"" + shortened(uri) + "\": " + why);
  };
  if (uri.empty()) return refused("is empty");
  if (has_scheme(uri)) return refused("only files beside the scene can be read");
  if (uri.find_first_of("?#") != std::string_view::npos) return refused("has a query or fragment");
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      decoded += uri[i];
      continue;
    }
    const int high = i + 1 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
    if (high < 0 || low < 0) return refused("has a broken percent sequence");
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  for (char c : decoded) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      return refused("has a control character");
    if (c == '\\') return refused("has a backslash");
  }
  for (std::size_t begin = 0; begin <= decoded.size();) {
    const std::size_t end = std::min(decoded.find('/', begin), decoded.size());
    const std::string_view segment = std::string_view(decoded).substr(begin, end - begin);
    if (segment.empty() || segment == "." || segment == "..") {
      return refused("leaves the scene's folder or has an empty segment");
    }
    begin = end + 1;
  }
  return std::filesystem::path(decoded);
}

}  // namespace sightline::gltf
