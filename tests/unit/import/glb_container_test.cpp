#include "core/import/gltf/glb_container.h"

#include <gtest/gtest.h>

#include "tests/unit/import/tiny_gltf_file.h"

namespace sightline::gltf {
namespace {

using test::append_word;
using test::glb_of;

std::vector<std::byte> sample() { return glb_of("{}", std::vector<std::byte>(8)); }

void write_word(std::vector<std::byte>& bytes, std::size_t at, std::uint32_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(GlbContainer, finds_both_chunks) {
  const auto bytes = sample();
  ASSERT_TRUE(has_glb_magic(bytes));
  const auto chunks = split_glb(bytes);
  ASSERT_TRUE(chunks.ok());
  EXPECT_EQ(chunks->json.size(), 4u);
  ASSERT_TRUE(chunks->binary.has_value());
  EXPECT_EQ(chunks->binary->size(), 8u);
}

TEST(GlbContainer, needs_no_binary_chunk) {
  const auto chunks = split_glb(glb_of("{}", {}));
  ASSERT_TRUE(chunks.ok());
  EXPECT_FALSE(chunks->binary.has_value());
}

TEST(GlbContainer, refuses_every_truncated_length) {
  const auto bytes = sample();
  for (std::size_t size = 4; size < bytes.size(); ++size) {
    auto cut = std::vector<std::byte>(bytes.begin(), bytes.begin() + static_cast<long>(size));
    EXPECT_FALSE(split_glb(cut).ok()) << size;
    // The same with a header that states the truncated length: the chunks give it away, unless
    // the cut falls between two of them.
    if (size < 12) continue;
    write_word(cut, 8, static_cast<std::uint32_t>(size));
    EXPECT_EQ(split_glb(cut).ok(), size == 24) << size;
  }
}

TEST(GlbContainer, reads_an_odd_chunk_where_the_next_one_is_found) {
  for (const std::uint32_t size : {1u, 2u, 3u}) {
    auto bytes = sample();
    write_word(bytes, 12, size);
    const auto chunks = split_glb(bytes);
    ASSERT_TRUE(chunks.ok());
    EXPECT_EQ(chunks->unaligned_chunk, 0u);
    EXPECT_EQ(chunks->json.size(), size);
    EXPECT_EQ(chunks->binary->size(), 8u);
    bytes.erase(bytes.begin() + 20 + static_cast<long>(size), bytes.begin() + 24);
    write_word(bytes, 8, static_cast<std::uint32_t>(bytes.size()));
    EXPECT_EQ(split_glb(bytes)->binary->size(), 8u);
  }
  auto nowhere = sample();
  write_word(nowhere, 12, 3);
  write_word(nowhere, 28, 0);
  EXPECT_EQ(split_glb(nowhere).error().code, "GLTF_CONTAINER_INVALID");
  auto last = sample();
  write_word(last, 24, 7);
  EXPECT_EQ(split_glb(last)->unaligned_chunk, 1u);
}

TEST(GlbContainer, refuses_lengths_near_the_end_of_32_bits) {
  for (std::uint32_t length : {0xffffffffu, 0xfffffffcu, 0x80000000u}) {
    auto bytes = sample();
    write_word(bytes, 12, length);
    EXPECT_FALSE(split_glb(bytes).ok());
    bytes = sample();
    write_word(bytes, 24, length);
    EXPECT_FALSE(split_glb(bytes).ok());
  }
}

TEST(GlbContainer, knows_version_two_only) {
  auto bytes = sample();
  write_word(bytes, 4, 3);
  EXPECT_EQ(split_glb(bytes).error().code, "GLTF_VERSION_UNSUPPORTED");
}

TEST(GlbContainer, wants_json_first_and_passes_over_unknown_chunks) {
  auto swapped = sample();
  write_word(swapped, 16, 0x004e4942);
  EXPECT_FALSE(split_glb(swapped).ok());

  auto longer = sample();
  append_word(longer, 4);
  append_word(longer, 0x12345678);
  append_word(longer, 7);
  write_word(longer, 8, static_cast<std::uint32_t>(longer.size()));
  const auto chunks = split_glb(longer);
  ASSERT_TRUE(chunks.ok());
  EXPECT_EQ(chunks->binary->size(), 8u);
}

TEST(GlbContainer, counts_bytes_beyond_its_end) {
  auto bytes = sample();
  bytes.resize(bytes.size() + 5);
  const auto chunks = split_glb(bytes);
  ASSERT_TRUE(chunks.ok());
  EXPECT_EQ(chunks->bytes_after_end, 5u);
}

}  // namespace
}  // namespace sightline::gltf
