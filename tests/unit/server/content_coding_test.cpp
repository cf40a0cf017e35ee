// Compressed bodies: whatever pieces they come in, the same bytes; and what is broken says so.

#include "server/http/content_coding.h"

#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

std::string some_text(std::size_t size) {
  std::mt19937_64 random(91);
  std::string text;
  while (text.size() < size) text += std::to_string(random() % 1000) + (random() % 9 ? "," : "\n");
  text.resize(size);
  return text;
}

TEST(ContentDecoder, says_what_a_window_takes) {
  ContentDecoder gzip(Coding::kGzip), zstd(Coding::kZstd);
  EXPECT_LT(gzip.bytes(), 200'000u);
  EXPECT_LT(zstd.bytes(), 300'000u);
  // By RFC 8878, 3.1.1: a window of 8 MiB, then one block, not the last, of 131,072 blanks.
  std::string_view frame("\x28\xb5\x2f\xfd\x00\x68\x02\x00\x10 ", 10);
  EXPECT_FALSE(zstd.decode(frame).empty());
  EXPECT_GE(zstd.bytes(), std::size_t{8} << 20);
}

std::string encoded(Coding coding, std::string_view text, std::size_t parts = 1) {
  ContentEncoder encoder(coding);
  std::string out;
  for (std::size_t i = 0; i < parts; ++i) {
    const std::size_t from = text.size() * i / parts, to = text.size() * (i + 1) / parts;
    out += encoder.encode(text.substr(from, to - from), i + 1 == parts);
  }
  return out;
}

/// Fed `step` bytes at a time.
std::string decoded(ContentDecoder& decoder, std::string_view bytes, std::size_t step) {
  std::string text;
  while (!bytes.empty() && !decoder.is_broken()) {
    std::string_view input = bytes.substr(0, step);
    bytes.remove_prefix(input.size());
    for (;;) {
      const std::span<const char> piece = decoder.decode(input);
      EXPECT_LE(piece.size(), 65536u);
      text.append(piece.data(), piece.size());
      if (piece.empty()) break;
    }
    EXPECT_TRUE(input.empty() || decoder.is_broken());
  }
  return text;
}

class ContentCoding : public testing::TestWithParam<Coding> {};

TEST_P(ContentCoding, comes_back_as_it_was_in_any_pieces) {
  for (const std::size_t size : {0u, 1u, 1000u, 300000u}) {
    const std::string text = some_text(size);
    for (const std::size_t parts : {1u, 7u}) {
      const std::string bytes = encoded(GetParam(), text, parts);
      for (const std::size_t step : {std::size_t{1}, std::size_t{1000}, bytes.size()}) {
        ContentDecoder decoder(GetParam());
        EXPECT_EQ(decoded(decoder, bytes, step), text);
        EXPECT_TRUE(decoder.is_whole());
      }
    }
  }
}

TEST_P(ContentCoding, says_all_that_it_was_told_before_the_end) {
  ContentEncoder encoder(GetParam());
  ContentDecoder decoder(GetParam());
  for (int i = 0; i < 20; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    EXPECT_EQ(decoded(decoder, encoder.encode(line, false), 5), line);
    EXPECT_FALSE(decoder.is_whole());
  }
}

TEST_P(ContentCoding, may_be_several_one_behind_the_other) {
  const std::string bytes = encoded(GetParam(), "one ") + encoded(GetParam(), "two");
  for (const std::size_t step : {std::size_t{1}, bytes.size()}) {
    ContentDecoder decoder(GetParam());
    EXPECT_EQ(decoded(decoder, bytes, step), "one two");
    EXPECT_TRUE(decoder.is_whole());
  }
}

TEST_P(ContentCoding, notices_a_cut_and_damage) {
  const std::string text = some_text(5000), bytes = encoded(GetParam(), text);
  for (std::size_t size = 1; size < bytes.size(); size += 37) {
    ContentDecoder decoder(GetParam());
    EXPECT_EQ(decoded(decoder, bytes.substr(0, size), 100), text.substr(0, 0) + text.substr(0, [&] {
      ContentDecoder again(GetParam());
      return decoded(again, bytes.substr(0, size), 100).size();
    }()));
    EXPECT_FALSE(decoder.is_whole()) << size;
  }
  std::mt19937_64 random(92);
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = bytes;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    ContentDecoder decoder(GetParam());
    decoded(decoder, damaged, 1 + random() % damaged.size());
  }
  ContentDecoder decoder(GetParam());
  decoded(decoder, "no such thing at all", 20);
  EXPECT_TRUE(decoder.is_broken());
}

TEST_P(ContentCoding, hands_a_bomb_on_in_pieces) {
  const std::string bytes = encoded(GetParam(), std::string(64 << 20, '\0'));
  EXPECT_LT(bytes.size(), 400'000u);
  ContentDecoder decoder(GetParam());
  std::string_view input = bytes;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(decoder.decode(input).size(), 65536u);
}

INSTANTIATE_TEST_SUITE_P(Both, ContentCoding, testing::Values(Coding::kGzip, Coding::kZstd),
                         [](const auto& coding) { return std::string(coding_name(coding.param)); });

TEST(ContentCodingNames, are_those_of_http) {
  EXPECT_EQ(find_coding(""), Coding::kIdentity);
  EXPECT_EQ(find_coding(" Identity "), Coding::kIdentity);
  EXPECT_EQ(find_coding("GZIP"), Coding::kGzip);
  EXPECT_EQ(find_coding("zstd"), Coding::kZstd);
  EXPECT_EQ(find_coding("br"), std::nullopt);
  EXPECT_EQ(find_coding("gzip, gzip"), std::nullopt);
}

TEST(ContentCodingNames, are_chosen_by_weight) {
  EXPECT_EQ(choose_coding(""), Coding::kIdentity);
  EXPECT_EQ(choose_coding("br, deflate"), Coding::kIdentity);
  EXPECT_EQ(choose_coding("gzip, deflate, br"), Coding::kGzip);
  EXPECT_EQ(choose_coding("gzip, deflate, br, zstd"), Coding::kZstd);
  EXPECT_EQ(choose_coding("gzip;q=1.0, zstd; q=0.5"), Coding::kGzip);
  EXPECT_EQ(choose_coding("gzip;q=0, *"), Coding::kZstd);
  EXPECT_EQ(choose_coding("*;q=0"), Coding::kIdentity);
  EXPECT_EQ(choose_coding("identity;q=1, gzip;q=0.1"), Coding::kIdentity);
  EXPECT_EQ(choose_coding("identity;q=0.5, gzip"), Coding::kGzip);
  EXPECT_EQ(choose_coding("identity, zstd"), Coding::kZstd);
  EXPECT_EQ(choose_coding("gzip;q=x"), Coding::kIdentity);
  EXPECT_EQ(choose_coding(",;,q,;;="), Coding::kIdentity);
}

}  // namespace
}  // namespace sightline
