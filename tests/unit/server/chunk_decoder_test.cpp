#include "server/http/chunk_decoder.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline {
namespace {

struct Decoded {
  std::string payload, rest;
  bool over = false, broken = false;
};

/// In pieces of so many bytes, each decoded in its own place.
Decoded decode(const std::string& coded, std::size_t piece) {
  ChunkDecoder decoder;
  Decoded result;
  for (std::size_t at = 0; at < coded.size(); at += piece) {
    std::string part = coded.substr(at, piece);
    std::string_view left = part;
    const std::size_t count = decoder.decode(left, part.data());
    result.rest += std::string(left);
    result.payload += part.substr(0, count);
  }
  result.over = decoder.is_over();
  result.broken = decoder.is_broken();
  return result;
}

TEST(ChunkDecoder, gives_the_same_payload_however_the_bytes_come) {
  const std::string coded =
      "3\r\nabc\r\n00000a;name=\"value\"\r\n0123456789\r\n0\r\nTrailer: x\r\n\r\nGET ";
  for (std::size_t piece = 1; piece <= coded.size(); ++piece) {
    const Decoded decoded = decode(coded, piece);
    EXPECT_TRUE(decoded.over);
    EXPECT_EQ(decoded.payload, "abc0123456789");
    EXPECT_EQ(decoded.rest, "GET ");
  }
}

TEST(ChunkDecoder, is_not_over_before_the_last_byte) {
  const std::string coded = "1\r\na\r\n0\r\n\r\n";
  for (std::size_t size = 0; size < coded.size(); ++size) {
    const Decoded decoded = decode(coded.substr(0, size), 3);
    EXPECT_FALSE(decoded.over || decoded.broken) << size;
  }
}

TEST(ChunkDecoder, refuses_what_another_program_could_read_otherwise) {
  for (const std::string& coded :
       {std::string("+1\r\na"), std::string("-1\r\na"), std::string("0x1\r\na"),
        std::string(" 1\r\na"), std::string("1 \r\na"), std::string("\r\n"), std::string(";a\r\n"),
        std::string("1\na"), std::string("1\ra"), std::string("1\r\nab"), std::string("1\r\na\n"),
        std::string("1\r\na\rb"), std::string("1000000000000000\r\n"), std::string("0\r\n\rx"),
        std::string("0\r\na\nb"), std::string("1;a\nb"), "1;" + std::string(9000, 'x'),
        "0\r\n" + std::string(9000, 'x'), std::string("1;\0\r\n", 5)}) {
    EXPECT_TRUE(decode(coded, 1).broken) << coded.substr(0, 20);
    EXPECT_TRUE(decode(coded, coded.size()).broken) << coded.substr(0, 20);
  }
}

}  // namespace
}  // namespace sightline
