#include "core/query/similar_names.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace sightline {
namespace {

using Names = std::vector<std::string>;

std::vector<std::string_view> similar(std::string_view pattern, const Names& names,
                                      std::uint64_t most_steps = 1 << 20) {
  const Deadline never = Deadline::never();
  DeadlineWatch watch(never);
  return similar_names(
      pattern, names.size(), [&](std::size_t i) -> std::string_view { return names[i]; },
      most_steps, watch);
}

TEST(SimilarNames, come_in_the_order_of_their_distance) {
  const Names names{"roofs", "door", "Roof", "proof", "roofs", "boot", "window"};
  EXPECT_EQ(similar("roof", names), (std::vector<std::string_view>{"Roof", "roofs", "proof"}));
}

TEST(SimilarNames, stand_for_typing_errors_of_patterns_too) {
  const Names names{"house 1", "house 2", "clock tower", "leaves"};
  EXPECT_EQ(similar("huose*", names), (std::vector<std::string_view>{"house 1", "house 2"}));
  EXPECT_EQ(similar("house??", {"house 12345", "house 1234567"}), std::vector<std::string_view>{});
  EXPECT_EQ(similar("tower", names), std::vector<std::string_view>{"clock tower"});
  EXPECT_EQ(similar("leafs", names), std::vector<std::string_view>{"leaves"});
  EXPECT_EQ(similar("twon", {"town", "down"}), std::vector<std::string_view>{"town"});
  EXPECT_EQ(similar("*tover", names), std::vector<std::string_view>{"clock tower"});
}

TEST(SimilarNames, are_none_for_what_is_similar_to_everything) {
  const Names names{"a", "b", "", "ab", std::string(65, 'a')};
  for (const char* pattern : {"", "c", "*c", "?", "**c**"})
    EXPECT_TRUE(similar(pattern, names).empty()) << pattern;
  EXPECT_TRUE(similar(std::string(256, 'a'), names).empty());
  EXPECT_TRUE(similar(std::string(65, 'b'), names).empty());
}

TEST(SimilarNames, end_with_their_steps_and_with_their_deadline) {
  Names names(100'000, "nothing of the kind");
  names.emplace_back("roof");
  EXPECT_EQ(similar("rooof", names, 4 << 20), std::vector<std::string_view>{"roof"});
  EXPECT_TRUE(similar("rooof", names, 100'000).empty());
  const Deadline past = Deadline::in(std::chrono::milliseconds(-1));
  DeadlineWatch watch(past);
  std::size_t looked = 0;
  similar_names(
      "rooof", names.size(),
      [&](std::size_t i) -> std::string_view {
        ++looked;
        return names[i];
      },
      1 << 30, watch);
  EXPECT_EQ(looked, 1u);
}

}  // namespace
}  // namespace sightline
