#include "core/base/overflow_memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "core/base/unlinked_file.h"

namespace sightline {
namespace {

constexpr std::uint64_t kMany = 1ull << 30;

/// Fills a piece with bytes that depend on its number.
void fill(std::byte* at, std::size_t size, unsigned number) {
  for (std::size_t i = 0; i < size; ++i) at[i] = static_cast<std::byte>((i * 31 + number) >> 3);
}

bool is_filled(const std::byte* at, std::size_t size, unsigned number) {
  for (std::size_t i = 0; i < size; ++i) {
    if (at[i] != static_cast<std::byte>((i * 31 + number) >> 3)) return false;
  }
  return true;
}

TEST(OverflowMemory, keeps_what_was_written_beyond_its_limit) {
  const auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  memory->set_resident_limit(4 << 20);
  // Pieces that share a file, and pieces with a file of their own.
  const std::size_t sizes[] = {1, 1000, 3 << 20, 20 << 20, 64, 24 << 20};
  std::vector<std::shared_ptr<std::byte>> pieces;
  for (unsigned i = 0; i < std::size(sizes); ++i) {
    pieces.push_back(memory->take(sizes[i]));
    ASSERT_NE(pieces.back(), nullptr);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pieces.back().get()) % 64, 0u);
    EXPECT_EQ(*pieces.back(), std::byte{0});
    EXPECT_TRUE(memory->contains(pieces.back().get() + sizes[i] - 1));
    fill(pieces.back().get(), sizes[i], i);
  }
  EXPECT_GE(memory->bytes(), std::uint64_t{44} << 20);
  while (memory->evicted_bytes() < std::uint64_t{44} << 20) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (unsigned i = 0; i < std::size(sizes); ++i) {
      ASSERT_TRUE(is_filled(pieces[i].get(), sizes[i], i)) << i;
    }
  }
  int elsewhere = 0;
  EXPECT_FALSE(memory->contains(&elsewhere));
  pieces.clear();
  EXPECT_EQ(memory->bytes(), 0u);
}

TEST(OverflowMemory, has_the_bytes_of_unmapped_pages) {
  constexpr std::size_t kBytes = 3 << 20;
  const auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  memory->set_resident_limit(kMany);
  EXPECT_EQ(memory->resident_limit(), kMany);
  const auto piece = memory->take(kBytes);
  fill(piece.get(), kBytes, 5);
  OverflowMemory::unmap_pages(piece.get(), kBytes);
  OverflowMemory::map_pages(piece.get(), kBytes);
  EXPECT_TRUE(is_filled(piece.get(), kBytes, 5));
}

TEST(OverflowMemory, evicts_nothing_for_other_files_that_are_read_later) {
  constexpr std::size_t kOther = 16 << 20;
  const int file = make_unlinked_file(testing::TempDir());
  ASSERT_GE(file, 0);
  ASSERT_EQ(::ftruncate(file, kOther), 0);
  auto* const other =
      static_cast<volatile std::byte*>(::mmap(nullptr, kOther, PROT_READ, MAP_SHARED, file, 0));
  ::close(file);
  ASSERT_NE(const_cast<std::byte*>(other), MAP_FAILED);
  const auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  memory->set_resident_limit(4 << 20);
  const auto piece = memory->take(1 << 20);
  fill(piece.get(), 1 << 20, 3);
  for (std::size_t i = 0; i < kOther; i += 4096) (void)other[i];
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const std::uint64_t once = memory->evicted_bytes();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(memory->evicted_bytes(), once);
  ::munmap(const_cast<std::byte*>(other), kOther);
}

TEST(OverflowMemory, outlives_its_other_holders) {
  auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  const auto piece = memory->take(5000);
  memory.reset();
  fill(piece.get(), 5000, 7);
  EXPECT_TRUE(is_filled(piece.get(), 5000, 7));
}

TEST(OverflowMemory, takes_back_whole_pages_of_one_piece) {
  const auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  const auto small = memory->take(100), first = memory->take(4096 * 3 + 5);
  const auto next = memory->take(70'000);
  const std::uint64_t before = memory->bytes();
  fill(small.get(), 100, 1);
  fill(first.get(), 4096 * 3 + 5, 2);
  fill(next.get(), 70'000, 3);
  memory->give_back(first.get() + 4096, 12'288);
  EXPECT_TRUE(is_filled(small.get(), 100, 1));
  EXPECT_TRUE(is_filled(first.get(), 4096, 2));
  EXPECT_TRUE(is_filled(next.get(), 70'000, 3));
  EXPECT_LE(memory->bytes(), before);
}

TEST(OverflowMemory, ends_with_its_last_piece) {
  auto memory = OverflowMemory::make(testing::TempDir(), kMany);
  const std::weak_ptr<OverflowMemory> watched = memory;
  auto piece = memory->take(5000);
  memory.reset();
  EXPECT_FALSE(watched.expired());
  piece.reset();
  EXPECT_TRUE(watched.expired());
}

TEST(OverflowMemory, refuses_what_its_files_have_no_room_for) {
  const auto small = OverflowMemory::make(testing::TempDir(), 100 << 20);
  auto piece = small->take(70 << 20);
  EXPECT_NE(piece, nullptr);
  EXPECT_EQ(small->take(40 << 20), nullptr);
  EXPECT_EQ(small->take(std::size_t{1} << 62), nullptr);
  EXPECT_EQ(small->take(static_cast<std::size_t>(-1)), nullptr);
  piece.reset();
  EXPECT_NE(small->take(40 << 20), nullptr);
  EXPECT_EQ(OverflowMemory::make("/proc/nowhere", kMany)->take(10), nullptr);
}

}  // namespace
}  // namespace sightline
