#include "core/import/input/refusal.h"

#include <gtest/gtest.h>

namespace sightline::gltf {
namespace {

TEST(Shortened, leaves_short_text_alone_and_cuts_long_text) {
  EXPECT_EQ(shortened("house 3"), "house 3");
  EXPECT_EQ(shortened(std::string(1000, 'x'), 5), "xxxxx...");
  EXPECT_EQ(shortened("12345", 5), "12345");
}

TEST(Shortened, cuts_between_characters) {
  EXPECT_EQ(shortened("\xc3\xa9\xc3\xa9\xc3\xa9", 3), "\xc3\xa9...");
  EXPECT_EQ(shortened("\xf0\x9f\x8f\xa0x", 4), "\xf0\x9f\x8f\xa0...");
}

TEST(Shortened, replaces_what_a_message_cannot_hold) {
  EXPECT_EQ(shortened(std::string_view("a\0b\nc\x7f", 6)), "a?b?c?");
  EXPECT_EQ(shortened("\xff\xc0\x80\xed\xa0\x80\xc3"), "???????");
  EXPECT_EQ(shortened("\xe2\x82"), "??");
}

}  // namespace
}  // namespace sightline::gltf
