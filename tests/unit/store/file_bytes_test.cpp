// Files in memory: what happens to a file afterwards reaches nobody.

#include "core/store/file_bytes.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/content_hash.h"
#include "tests/unit/store/text_scenes.h"

namespace sightline {
namespace {

constexpr std::size_t kLarge = (9 << 20) + 17;

std::string text_of_size(std::size_t size) {
  std::string text(size, 0);
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(1 + i * 7919 % 251);
  return text;
}

Result<FileBytes> read(const std::filesystem::path& file, std::uint64_t& fingerprint) {
  const auto opened = open_file(file, O_RDONLY, "read it");
  if (!opened) return opened.error();
  return FileBytes::read(*opened, "read it", fingerprint);
}

Result<FileBytes> read(const std::filesystem::path& file) {
  const auto opened = open_file(file, O_RDONLY, "read it");
  if (!opened) return opened.error();
  return FileBytes::read(*opened, "read it");
}

std::string_view view_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(FileBytes, are_those_of_the_file_and_stay_when_it_is_cut_or_written_over) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "file";
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, FileBytes::kSharedFrom - 1,
                                 FileBytes::kSharedFrom, kLarge}) {
    const std::string text = text_of_size(size);
    std::ofstream(file, std::ios::binary) << text;
    std::uint64_t fingerprint = 0;
    const auto bytes = read(file, fingerprint);
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(fingerprint, hash_in_pieces(bytes->bytes()));
    EXPECT_EQ(bytes->is_shared(), size >= FileBytes::kSharedFrom);
    std::ofstream(file, std::ios::binary | std::ios::in) << std::string(size / 2, 'x');
    EXPECT_TRUE(view_of(bytes->bytes()) == text) << size;
    std::filesystem::resize_file(file, 0);
    EXPECT_TRUE(view_of(bytes->bytes()) == text) << size;
  }
}

TEST(FileBytes, adopt_pages_that_grew_without_a_copy) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, FileBytes::kSharedFrom - 1,
                                 FileBytes::kSharedFrom, kLarge}) {
    const std::string text = text_of_size(size);
    OwnedPages pages;
    std::size_t filled = 0, room = 0;
    while (filled < size) {
      room = whole_pages(room + room / 2 + 5000);
      enlarge(pages, room);
      const std::size_t more = std::min(size, room) - filled;
      std::memcpy(pages.get() + filled, text.data() + filled, more);
      filled += more;
    }
    const std::byte* const place = pages.get();
    const auto bytes = FileBytes::adopt(std::move(pages), size, "adopt it");
    ASSERT_TRUE(bytes.ok());
    EXPECT_TRUE(view_of(bytes->bytes()) == text) << size;
    EXPECT_EQ(bytes->is_shared(), size >= FileBytes::kSharedFrom);
    EXPECT_EQ(size > 0 && bytes->bytes().data() == place, bytes->is_shared());
  }
}

TEST(FileBytes, adopt_copies_what_exceeds_the_memory_budget) {
  const TemporaryFolder folder;
  std::shared_ptr<OverflowMemory> overflow = OverflowMemory::make(folder.path(), 1ull << 30);
  const std::string text = text_of_size(kLarge);
  OwnedPages pages;
  enlarge(pages, kLarge);
  std::memcpy(pages.get(), text.data(), kLarge);
  const std::byte* const place = pages.get();
  const auto bytes = FileBytes::adopt(std::move(pages), kLarge, "adopt it",
                                      [&](std::uint64_t) { return overflow; });
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(view_of(bytes->bytes()) == text);
  EXPECT_NE(bytes->bytes().data(), place);
}

TEST(FileBytes, keep_what_was_claimed_and_give_the_other_pages_back) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "file";
  const std::string text = text_of_size(kLarge);
  std::ofstream(file, std::ios::binary) << text;
  const auto bytes = read(file);
  ASSERT_TRUE(bytes.ok());
  const std::pair<std::size_t, std::size_t> parts[] = {{5'000'000, 5'300'000},
                                                       {100, 101},
                                                       {5'200'000, 5'200'001},
                                                       {8'191, 8'193},
                                                       {kLarge - 1, kLarge}};
  for (const auto& [begin, end] : parts) bytes->claim(bytes->bytes().subspan(begin, end - begin));
  bytes->drop_unclaimed();
  const std::string_view now = view_of(bytes->bytes());
  for (const auto& [begin, end] : parts) {
    EXPECT_TRUE(now.substr(begin, end - begin) == text.substr(begin, end - begin)) << begin;
  }
  const auto dropped = static_cast<std::size_t>(std::count(now.begin(), now.end(), 0));
  EXPECT_GT(dropped, kLarge - 300'001 - std::size_t{7} * 4096);
}

TEST(FileBytes, are_made_of_what_fills_them) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, FileBytes::kSharedFrom}) {
    const std::string text = text_of_size(size);
    const auto made = FileBytes::make(size, "make it", [&](std::span<std::byte> room) {
      std::transform(text.begin(), text.end(), room.begin(),
                     [](char each) { return static_cast<std::byte>(each); });
      return success();
    });
    ASSERT_TRUE(made.ok());
    EXPECT_EQ(made->is_shared(), size >= FileBytes::kSharedFrom);
    EXPECT_TRUE(view_of(made->bytes()) == text) << size;
  }
  const auto failed = FileBytes::make(10, "make it", [](auto) {
    return Status(Error{ErrorKind::kBusy, "NO", "no", ""});
  });
  EXPECT_EQ(failed.error().code, "NO");
  const auto too_large =
      FileBytes::make(std::size_t{1} << 60, "make it", [](auto) { return success(); });
  EXPECT_EQ(too_large.error().code, "MEMORY_FULL");
}

TEST(FileBytes, of_a_folder_are_an_error) {
  const TemporaryFolder folder;
  const auto bytes = read(folder.path());
  ASSERT_FALSE(bytes.ok());
  EXPECT_EQ(bytes.error().code, "STORE_IO");
}

}  // namespace
}  // namespace sightline
