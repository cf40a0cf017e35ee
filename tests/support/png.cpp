#include "tests/support/png.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace sightline::test {

namespace {

using Bytes = std::vector<std::uint8_t>;

void append_big_endian(Bytes& to, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) to.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// The checksum of PNG's chunks (ISO 3309).
std::uint32_t crc32(const std::uint8_t* data, std::size_t size) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c >> 1) ^ ((c & 1u) != 0 ? 0xedb88320u : 0u);
      table[i] = c;
    }
    return table;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t i = 0; i < size; ++i) crc = kTable[(crc ^ data[i]) & 0xffu] ^ (crc >> 8);
  return ~crc;
}

void append_chunk(Bytes& png, std::string_view name, const Bytes& payload) {
  append_big_endian(png, static_cast<std::uint32_t>(payload.size()));
  const std::size_t begin = png.size();
  png.insert(png.end(), name.begin(), name.end());
  png.insert(png.end(), payload.begin(), payload.end());
  append_big_endian(png, crc32(png.data() + begin, png.size() - begin));
}

/// zlib's format with stored blocks.
Bytes stored(const Bytes& raw) {
  Bytes out = {0x78, 0x01};
  for (std::size_t at = 0; at < raw.size();) {
    const std::size_t size = std::min<std::size_t>(raw.size() - at, 0xffff);
    out.push_back(at + size == raw.size() ? 1 : 0);
    for (const std::size_t number : {size, ~size}) {
      out.push_back(static_cast<std::uint8_t>(number & 0xff));
      out.push_back(static_cast<std::uint8_t>(number >> 8 & 0xff));
    }
    out.insert(out.end(), raw.begin() + static_cast<std::ptrdiff_t>(at),
               raw.begin() + static_cast<std::ptrdiff_t>(at + size));
    at += size;
  }
  std::uint32_t a = 1, b = 0;
  for (const std::uint8_t byte : raw) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  append_big_endian(out, b << 16 | a);
  return out;
}

}  // namespace

std::vector<std::byte> noise_png(std::uint32_t width, std::uint32_t height, std::uint32_t seed) {
  Bytes raw;
  std::uint32_t noise = seed;
  for (std::uint32_t y = 0; y < height; ++y) {
    raw.push_back(0);  // no filter
    for (std::uint32_t x = 0; x < width; ++x) {
      noise = noise * 1664525u + 1013904223u;
      raw.push_back(static_cast<std::uint8_t>(noise >> 24));
    }
  }
  Bytes header;
  append_big_endian(header, width);
  append_big_endian(header, height);
  header.insert(header.end(), {8, 0, 0, 0, 0});
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  append_chunk(png, "IHDR", header);
  append_chunk(png, "IDAT", stored(raw));
  append_chunk(png, "IEND", {});
  std::vector<std::byte> bytes(png.size());
  std::transform(png.begin(), png.end(), bytes.begin(), [](auto b) { return std::byte{b}; });
  return bytes;
}

}  // namespace sightline::test
