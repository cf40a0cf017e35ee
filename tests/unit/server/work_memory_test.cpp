#include "server/http/work_memory.h"

#include <gtest/gtest.h>

#include <optional>
#include <thread>

namespace sightline {
namespace {

constexpr std::uint64_t kKib = 1 << 10, kMib = 1 << 20;

bool is_busy(const Status& status) {
  return !status && status.error().code == "MEMORY_BUSY" && status.error().kind == ErrorKind::kBusy;
}

TEST(WorkMemoryShare, fits_what_all_may_take_together) {
  TrafficMemory traffic(10'000);
  WorkMemory memory(traffic, 128, 1000);  // the last 16 are kept for shares of no more than 8
  TrafficMemory::Holder holder;
  WorkMemory::Share a(memory, holder), b(memory, holder), large(memory, holder);
  EXPECT_TRUE(a.grow(60).ok());
  EXPECT_TRUE(b.grow(52).ok());
  // One goes beyond, and is counted by itself.
  EXPECT_TRUE(large.grow(900).ok());
  EXPECT_TRUE(is_busy(a.grow(1)));
  b.keep(10);
  EXPECT_TRUE(a.grow(42).ok());
  EXPECT_TRUE(is_busy(a.grow(1)));
  EXPECT_TRUE(large.grow(100).ok());
}

TEST(WorkMemoryShare, is_there_for_who_asks_for_little) {
  TrafficMemory traffic(10'000);
  WorkMemory memory(traffic, 128, 1000);
  TrafficMemory::Holder holder;
  WorkMemory::Share beyond(memory, holder), large(memory, holder), little(memory, holder),
      next(memory, holder), late(memory, holder);
  ASSERT_TRUE(beyond.grow(1000).ok() && large.grow(112).ok());
  EXPECT_EQ(memory.little(), 8U);
  EXPECT_TRUE(is_busy(little.grow(9)));
  EXPECT_TRUE(little.grow(8).ok());
  EXPECT_TRUE(is_busy(little.grow(1)));
  EXPECT_TRUE(next.grow(8).ok());
  EXPECT_TRUE(is_busy(late.grow(1)));
  next.keep(4);
  EXPECT_TRUE(late.grow(4).ok());
}

TEST(WorkMemoryShare, lets_one_at_a_time_go_beyond) {
  TrafficMemory traffic(10'000);
  WorkMemory memory(traffic, 128, 1000);
  TrafficMemory::Holder holder;
  WorkMemory::Share first(memory, holder), second(memory, holder);
  EXPECT_TRUE(first.grow(50).ok());
  EXPECT_TRUE(first.grow(200).ok());
  EXPECT_TRUE(second.grow(112).ok());
  EXPECT_TRUE(is_busy(second.grow(1)));
  // What it keeps does not fit beside the other's: it stays the one.
  first.keep(50);
  EXPECT_TRUE(is_busy(second.grow(1)));
  first.keep(0);
  EXPECT_TRUE(second.grow(1).ok());
  EXPECT_TRUE(first.grow(112).ok());
  EXPECT_TRUE(is_busy(first.grow(1)));
}

TEST(WorkMemoryShare, refuses_what_never_fits) {
  TrafficMemory traffic(10'000);
  WorkMemory memory(traffic, 100, 1000);
  TrafficMemory::Holder holder;
  WorkMemory::Share share(memory, holder);
  EXPECT_TRUE(share.grow(600).ok());
  const Status refused = share.wait(401, Deadline::never());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, "REQUEST_TOO_LARGE");
  EXPECT_EQ(refused.error().kind, ErrorKind::kTooLarge);
  EXPECT_FALSE(share.grow(~std::uint64_t{0}).ok());
  EXPECT_TRUE(share.grow(400).ok());
}

TEST(WorkMemoryShare, waits_for_its_turn) {
  TrafficMemory traffic(10'000);
  WorkMemory memory(traffic, 100, 1000);
  TrafficMemory::Holder holder;
  std::optional<WorkMemory::Share> first;
  first.emplace(memory, holder);
  ASSERT_TRUE(first->grow(500).ok());
  WorkMemory::Share second(memory, holder);
  std::thread waiter([&] { EXPECT_TRUE(second.wait(300, Deadline::never()).ok()); });
  first.reset();
  waiter.join();
}

TEST(RequestMemory, has_its_first_bytes_for_nothing) {
  TrafficMemory traffic(64 * kMib);
  WorkMemory bodies(traffic, kMib, kMib), work(traffic, kMib, 4 * kMib);
  TrafficMemory::Holder holder;
  RequestMemory large(bodies, work, nullptr, nullptr);
  ASSERT_TRUE(large.reserve(4 * kMib).ok());
  WorkMemory::Share rest(work, holder), kept(work, holder), last(work, holder);
  ASSERT_TRUE(rest.grow(7 * kMib / 8).ok());
  ASSERT_TRUE(kept.grow(kMib / 16).ok() && last.grow(kMib / 16).ok());
  Places nowhere(0);
  RequestMemory little(bodies, work, &nowhere, nullptr);
  EXPECT_TRUE(little.reserve(200 * kKib).ok());
  EXPECT_TRUE(little.reserve(56 * kKib).ok());
  // Nowhere to wait.
  EXPECT_TRUE(is_busy(little.reserve(1)));
  little.keep(100 * kKib);
  EXPECT_TRUE(little.reserve(156 * kKib).ok());
  // Who sends a large part of a stream keeps nobody waiting.
  large.keep_while_streaming(4 * kMib);
  rest.keep(kMib / 2);
  EXPECT_TRUE(little.reserve(kKib).ok());
}

TEST(RequestMemory, knows_whether_others_wait_for_it) {
  TrafficMemory traffic(64 * kMib);
  WorkMemory bodies(traffic, kMib, kMib), work(traffic, kMib, 8 * kMib);
  RequestMemory large(bodies, work, nullptr, nullptr), little(bodies, work, nullptr, nullptr);
  ASSERT_TRUE(large.reserve(4 * kMib).ok());
  ASSERT_TRUE(little.reserve(300 * kKib).ok());
  EXPECT_FALSE(large.keeps_others_waiting());
  std::thread waiter([&] {
    RequestMemory next(bodies, work, nullptr, nullptr);
    EXPECT_TRUE(next.reserve(4 * kMib).ok());
  });
  while (!large.keeps_others_waiting()) std::this_thread::yield();
  EXPECT_FALSE(little.keeps_others_waiting());
  large.keep(0);
  waiter.join();
  EXPECT_FALSE(large.keeps_others_waiting());
}

TEST(RequestMemory, waits_no_longer_than_its_request_may_take) {
  TrafficMemory traffic(10 * kMib);
  WorkMemory bodies(traffic, kMib, 10 * kMib), work(traffic, kMib, 10 * kMib);
  TrafficMemory::Holder other;
  WorkMemory::Share beyond(work, other);
  ASSERT_TRUE(beyond.grow(2 * kMib).ok());
  RequestMemory memory(bodies, work, nullptr, nullptr);
  memory.wait_until(Deadline::Clock::now() + std::chrono::milliseconds(20));
  const Status status = memory.reserve(2 * kMib);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, "DEADLINE");
}

TEST(RequestMemory, knows_whether_its_body_keeps_others_waiting) {
  TrafficMemory traffic(10 * kMib);
  WorkMemory bodies(traffic, kMib, 10 * kMib), work(traffic, kMib, 10 * kMib);
  RequestMemory large(bodies, work, nullptr, nullptr), small(bodies, work, nullptr, nullptr),
      late(bodies, work, nullptr, nullptr);
  ASSERT_TRUE(large.reserve_body(2 * kMib).ok() && small.reserve_body(kMib / 64).ok());
  EXPECT_FALSE(large.body_keeps_others_waiting());
  std::thread waiter([&] { EXPECT_TRUE(late.reserve_body(kMib).ok()); });
  while (!bodies.is_wanted()) std::this_thread::yield();
  EXPECT_TRUE(large.body_keeps_others_waiting());
  EXPECT_FALSE(small.body_keeps_others_waiting());
  large.forget_body();
  small.forget_body();
  waiter.join();
}

}  // namespace
}  // namespace sightline
