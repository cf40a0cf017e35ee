#include "server/http/heap.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <vector>

namespace sightline {
namespace {

TEST(KeptBlocks, are_taken_again) {
  KeptBlocks kept;
  EXPECT_EQ(kept.take(3000), nullptr);
  void* const block = std::malloc(KeptBlocks::rounded(3000));
  ASSERT_TRUE(kept.keep(block));
  EXPECT_EQ(kept.take(2000), nullptr);  // another shelf
  EXPECT_EQ(kept.take(4097), nullptr);
  EXPECT_EQ(kept.take(4096), block);
  EXPECT_EQ(kept.take(4096), nullptr);
  std::free(block);
}

TEST(KeptBlocks, are_as_large_as_what_is_asked_of_them) {
  KeptBlocks kept;
  // Not one of the door's own: 5,000 bytes serve those who ask for 4,096.
  void* const block = std::malloc(5000);
  ASSERT_TRUE(kept.keep(block));
  EXPECT_EQ(kept.take(5000), nullptr);
  EXPECT_EQ(kept.take(2049), block);
  std::free(block);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{33}, std::size_t{131'072}, std::size_t{131'073},
        std::size_t{1} << 40}) {
    EXPECT_GE(KeptBlocks::rounded(size), size);
  }
}

TEST(KeptBlocks, are_few) {
  KeptBlocks kept;
  std::size_t bytes = 0;
  for (std::size_t size = 16; size <= std::size_t{1} << 20; size = size * 5 / 4 + 1) {
    for (int i = 0; i < 200; ++i) {
      void* const block = std::malloc(size);
      if (kept.keep(block)) {
        bytes += size;
      } else {
        std::free(block);
      }
    }
  }
  EXPECT_GT(bytes, std::size_t{1} << 20);
  EXPECT_LT(bytes, std::size_t{3} << 20);
}

TEST(KeptBlocks, serve_their_thread) {
  std::vector<char> before(100'000);
  {
    const KeptBlocks kept;
    for (int round = 0; round < 3; ++round) {
      std::vector<std::vector<char>> some;
      for (std::size_t size = 1; size < 1'000'000; size *= 3) some.emplace_back(size, 'x');
      before.swap(some.back());  // one goes, one stays
    }
  }
  EXPECT_GE(before.size(), 500'000u);
}

}  // namespace
}  // namespace sightline
