#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// Bytes of the well-formed UTF-8 sequence that `text` begins with [RFC3629]; 0 when it is none.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return 0;
  }
  // Overlong forms, surrogates, beyond U+10FFFF.
  const unsigned second = byte(1);
  if (lead == 0xe0 && second < 0xa0) return 0;
  if (lead == 0xed && second > 0x9f) return 0;
  if (lead == 0xf0 && second < 0x90) return 0;
  if (lead == 0xf4 && second > 0x8f) return 0;
  return length;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t most) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    if (out.size() + (length > 0 ? length : 1) > most) return out + "...";
    const auto first = static_cast<unsigned char>(text[0]);
    if (length == 0 || first < 0x20 || first == 0x7f) {
      out += '?';
      text.remove_prefix(1);
    } else {
      out += text.substr(0, length);
      text.remove_prefix(length);
    }
  }
  return out;
}

Error beyond_limit(std::string_view name, std::string_view what, std::uint64_t value,
                   std::uint64_t limit, std::string pointer) {
  return {
      ErrorKind::kTooLarge, "GLTF_LIMIT_" + std::string(name),
      std::string(what) + ": " + std::to_string(value) + ", the limit is " + std::to_string(limit),
      std::move(pointer)};
}

}  // namespace sightline::gltf
