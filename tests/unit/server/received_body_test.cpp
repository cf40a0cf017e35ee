#include "server/http/received_body.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

namespace sightline {
namespace {

std::string pattern(std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 31 + i / 251);
  return text;
}

RequestHead parse(const std::string& fields) {
  RequestHead head;
  EXPECT_FALSE(parse_request_head("POST / HTTP/1.1\r\nHost: x\r\n" + fields + "\r\n", {}, head));
  return head;
}

RequestHead head_of(std::size_t length) {
  return parse("Content-Length: " + std::to_string(length) + "\r\n");
}

/// All of a body that comes in pieces of that size.
bool feed(ReceivedBody& body, std::string text, std::size_t piece) {
  for (std::size_t at = 0; at < text.size();) {
    std::size_t taken = 0;
    if (!body.take(text.data() + at, std::min(piece, text.size() - at), taken)) return false;
    if (taken == 0) return true;
    at += taken;
  }
  return true;
}

std::string read_all(ReceivedBody& body, std::size_t piece) {
  std::string text, buffer(piece, '\0');
  for (std::size_t count = 0; (count = body.read(buffer.data(), piece)) > 0;) {
    text.append(buffer, 0, count);
  }
  return text;
}

class ReceivedBodyTest : public testing::Test {
 protected:
  MemoryBudget budget{2 << 20, 0};
  Spool spool{testing::TempDir(), 2 << 20};
};

TEST_F(ReceivedBodyTest, gives_back_what_came_however_it_is_cut) {
  // Budgets with room for no body, for the first 64 KiB of one, and for all in memory.
  constexpr std::size_t kPart = ReceivedBody::kPart, kWhole = ReceivedBody::kWhole;
  for (const std::size_t room : {std::size_t{0}, kPart, kWhole}) {
    MemoryBudget limited(ReceivedBody::kPartForWhole * room, 0);
    const std::size_t here = std::max(room, ReceivedBody::kInMemory);
    for (const std::size_t size : {1u, 4095u, 4096u, 4097u, 65537u, 300'000u, 1'200'000u}) {
      const std::size_t piece = size % 2 == 0 ? 1000 : 70'000;
      const std::string text = pattern(size);
      ReceivedBody body(head_of(size), limited, spool);
      ASSERT_TRUE(feed(body, text, piece));
      EXPECT_TRUE(body.is_whole());
      EXPECT_EQ(body.spooled(), size - std::min(size, here));
      EXPECT_LE(limited.taken(), room);
      EXPECT_EQ(body.spooled(), spool.used());
      EXPECT_EQ(body.unread(), size);
      EXPECT_TRUE(read_all(body, 777) == text);
      EXPECT_EQ(body.unread(), 0u);
      body.rewind();
      EXPECT_TRUE(read_all(body, 65536) == text);
    }
    EXPECT_EQ(limited.taken(), 0u);
  }
  EXPECT_EQ(spool.used(), 0u);
}

TEST_F(ReceivedBodyTest, takes_no_more_than_the_body) {
  ReceivedBody body(head_of(3), budget, spool);
  std::string input = "abcGET /";
  std::size_t taken = 0;
  EXPECT_TRUE(body.take(input.data(), input.size(), taken));
  EXPECT_EQ(taken, 3u);
  EXPECT_TRUE(body.is_whole());
  EXPECT_EQ(read_all(body, 10), "abc");
}

TEST_F(ReceivedBodyTest, removes_the_framing_of_chunks) {
  const RequestHead head = parse("Transfer-Encoding: chunked\r\n");
  ReceivedBody body(head, budget, spool);
  const std::string payload = pattern(100'000);
  std::string coded = "186A0\r\n" + payload + "\r\n3\r\nabc\r\n0\r\n\r\nGET /";
  EXPECT_TRUE(feed(body, coded, 1234));
  EXPECT_TRUE(body.is_whole());
  EXPECT_TRUE(read_all(body, 4096) == payload + "abc");

  ReceivedBody broken(head, budget, spool);
  EXPECT_TRUE(feed(broken, "no size\r\n", 100));
  EXPECT_TRUE(broken.is_broken());
}

TEST_F(ReceivedBodyTest, is_broken_when_the_client_ends_too_early) {
  ReceivedBody body(head_of(10), budget, spool);
  EXPECT_TRUE(feed(body, "12345", 5));
  EXPECT_FALSE(body.is_broken());
  body.end();
  EXPECT_TRUE(body.is_broken());
  EXPECT_EQ(body.to_come(), 5u);
  EXPECT_EQ(read_all(body, 10), "12345");
}

TEST_F(ReceivedBodyTest, holds_one_part_in_memory_or_in_the_file) {
  MemoryBudget none(0, 0);
  for (MemoryBudget* const room : {&budget, &none}) {
    ReceivedBody body(head_of(150'000), *room, spool);
    const std::string text = pattern(150'000);
    std::string got;
    for (std::size_t at = 0; at < text.size(); at += 50'000) {
      body.begin_part();
      EXPECT_EQ(body.dropped(), at);
      EXPECT_TRUE(feed(body, text.substr(at, 50'000), 50'000));
      EXPECT_EQ(body.spooled() == 0, room == &budget);
      got += read_all(body, 999);
    }
    EXPECT_TRUE(got == text);
    EXPECT_TRUE(body.is_whole());
    EXPECT_EQ(body.size(), text.size());
  }
  EXPECT_EQ(spool.used(), 0u);
  EXPECT_EQ(budget.taken(), 0u);
}

TEST_F(ReceivedBodyTest, says_when_the_spool_is_full) {
  // The last eighth is kept for small files.
  ReceivedBody large(head_of(4 << 20), budget, spool);
  EXPECT_FALSE(feed(large, pattern(4 << 20), 10'000));
  EXPECT_LE(spool.used(), (2u << 20) - (2u << 17));
  EXPECT_TRUE(spool.take(1000, 0));
  spool.give(1000);
}

TEST(Spool, says_where_no_file_can_be_made) {
  EXPECT_TRUE(SpoolFile::can_be_made_in(testing::TempDir()));
  const Status none = SpoolFile::can_be_made_in("/proc/nowhere");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "SPOOL_UNUSABLE");

  Spool spool("/proc/nowhere", 1 << 20);
  SpoolFile file(spool);
  EXPECT_FALSE(file.append("a"));
  EXPECT_EQ(spool.used(), 0u);
  char byte = 0;
  EXPECT_EQ(file.read(0, &byte, 1), 0u);
}

}  // namespace
}  // namespace sightline
