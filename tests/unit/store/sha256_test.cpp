#include "core/store/sha256.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "core/store/scene_id.h"
#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

TEST(Sha256, agrees_with_the_examples_of_its_standard) {
  EXPECT_EQ(hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

/// `size` bytes, passed in pieces of `piece` bytes.
std::string hash_in_background(const std::string& text, std::size_t piece) {
  BackgroundSha256 background;
  const auto bytes = std::as_bytes(std::span(text));
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    background.update(bytes.subspan(at, std::min(piece, bytes.size() - at)));
  BackgroundSha256 moved(std::move(background));
  return moved.finish();
}

TEST(BackgroundSha256, is_the_hash_of_all_pieces) {
  constexpr std::size_t kInline = BackgroundSha256::kInline;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, kInline, kInline + 1, 3 * kInline}) {
    std::string text(size, ' ');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 7919 % 251);
    for (const std::size_t piece : {std::size_t{77'777}, std::size_t{1} << 20, 3 * kInline})
      EXPECT_EQ(hash_in_background(text, piece), hash(text)) << size << " in pieces of " << piece;
  }
}

TEST(BackgroundSha256, may_be_abandoned) {
  const std::string text(2 * BackgroundSha256::kInline, 'x');
  BackgroundSha256 background;
  for (int i = 0; i < 2; ++i) background.update(std::as_bytes(std::span(text)));
}

TEST(SceneId, allows_what_is_safe_as_a_file_name_and_in_a_url) {
  for (const char* id : {"a", "town", "A-1_b.glb", "0", "-", "_", "a..b"}) {
    EXPECT_TRUE(is_scene_id(id)) << id;
  }
  EXPECT_TRUE(is_scene_id(std::string(128, 'x')));
  for (const char* id :
       {"", ".", "..", ".hidden", "a/b", "../a", "a b", "a%20", "é", "a\n", "a:b"}) {
    EXPECT_FALSE(is_scene_id(id)) << id;
  }
  EXPECT_FALSE(is_scene_id(std::string(129, 'x')));
  EXPECT_FALSE(is_scene_id(std::string_view("a\0b", 3)));
}

}  // namespace
}  // namespace sightline
