#include "server/access/key_ring.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(KeyRing, finds_the_key_whose_hash_it_has) {
  const auto key = make_key();
  ASSERT_TRUE(key.ok());
  const Key stored{"ci", Access::kWrite, key_sha256(*key)};
  const auto ring = KeyRing::parse("# comment\r\n\n  " + key_line(stored) + " \r\n");
  ASSERT_TRUE(ring.ok()) << ring.error().message;
  EXPECT_EQ(ring->size(), 1u);
  ASSERT_NE(ring->find(*key), nullptr);
  EXPECT_EQ(ring->find(*key)->name, "ci");
  EXPECT_EQ(ring->find(*key)->access, Access::kWrite);
  for (const std::string& other :
       {std::string(), *key + "x", key->substr(1), stored.sha256, std::string(5000, 'x')}) {
    EXPECT_EQ(ring->find(other), nullptr) << other;
  }
}

TEST(KeyRing, knows_sha256) {
  EXPECT_EQ(key_sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(KeyRing, takes_no_more_than_a_thousand_keys) {
  std::string text;
  for (int i = 0; i < 1000; ++i) {
    const std::string name = "k" + std::to_string(i);
    text += key_line({name, Access::kRead, key_sha256(name)}) + "\n";
  }
  EXPECT_TRUE(KeyRing::parse(text).ok());
  EXPECT_FALSE(KeyRing::parse(text + key_line({"x", Access::kRead, key_sha256("x")})).ok());
}

TEST(KeyRing, tells_texts_that_hold_a_key) {
  const std::string key = *make_key();
  for (const std::string& text : {key, "a" + key + "b", key.substr(0, 30), "slk_slk_" + key}) {
    EXPECT_TRUE(holds_key(text)) << text;
  }
  for (const char* text : {"", "slk_", "slk_town", "a-scene-with-quite-a-long-name-and-no-key"}) {
    EXPECT_FALSE(holds_key(text)) << text;
  }
}

}  // namespace
}  // namespace sightline
