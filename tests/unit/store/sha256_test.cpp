#include "core/store/sha256.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

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

TEST(FollowingSha256, is_the_hash_of_what_was_filled) {
  for (const std::size_t size : {0u, 1u, 1000u, 1u << 20u}) {
    std::string text(size, ' ');
    FollowingSha256 following(std::as_bytes(std::span(text.data(), text.size())));
    for (std::size_t filled = 0; filled < size;) {
      const std::size_t next = std::min(size, filled + 77'777);
      for (; filled < next; ++filled) text[filled] = static_cast<char>(filled * 7919 % 251);
      following.reach(filled);
    }
    EXPECT_EQ(following.finish(), hash(text)) << size;
  }
  const std::string text(1u << 20u, 'x');
  FollowingSha256 following(std::as_bytes(std::span(text.data(), text.size())));
  following.reach(500'000);
  EXPECT_EQ(following.finish(), hash(text.substr(0, 500'000)));
}

TEST(FollowingSha256, ends_when_nothing_was_filled) {
  const std::string text(1u << 20u, 'x');
  const FollowingSha256 following(std::as_bytes(std::span(text.data(), text.size())));
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
