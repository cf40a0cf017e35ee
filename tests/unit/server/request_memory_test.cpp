#include "server/http/request_memory.h"

#include <gtest/gtest.h>

#include <thread>

namespace sightline {
namespace {

using Holder = MemoryBudget::Holder;
using Wait = RequestMemory::Wait;
constexpr std::uint64_t kKib = 1 << 10, kMib = 1 << 20;

bool is_busy(const Status& status) {
  return !status && status.error().code == "MEMORY_BUSY" && status.error().kind == ErrorKind::kBusy;
}

TEST(MemoryBudget, bounds_the_sum) {
  MemoryBudget budget(128, 10'000);  // the last 16 are for holders of at most 8
  Holder a, b;
  EXPECT_TRUE(budget.take(a, 42));
  EXPECT_TRUE(budget.take(b, 40));
  EXPECT_TRUE(budget.charge(30));
  // Each has others beside it that hold more than half.
  EXPECT_FALSE(budget.take(a, 1));
  EXPECT_FALSE(budget.take(b, 1));
  EXPECT_FALSE(budget.charge(1));
  budget.release(30);
  EXPECT_TRUE(budget.take(a, 30));
  EXPECT_FALSE(budget.charge(1));
  EXPECT_EQ(budget.taken(), 112U);
}

TEST(MemoryBudget, gives_connections_half) {
  MemoryBudget budget(128, 10'000);
  EXPECT_TRUE(budget.charge(60));
  EXPECT_FALSE(budget.charge(5));
  EXPECT_FALSE(budget.charge(~std::uint64_t{0}));
  EXPECT_TRUE(budget.charge(4));
  budget.release(64);
  EXPECT_EQ(budget.taken(), 0U);
}

TEST(MemoryBudget, reserves_some_for_small_holders) {
  MemoryBudget budget(128, 10'000);
  Holder large, little, next, late;
  EXPECT_TRUE(budget.take(large, 62));
  EXPECT_TRUE(budget.charge(50));
  EXPECT_TRUE(budget.take(little, 8));
  EXPECT_FALSE(budget.take(little, 1));
  EXPECT_TRUE(budget.take(next, 8));
  EXPECT_FALSE(budget.take(late, 1));
  budget.keep(little, 0);
  EXPECT_FALSE(budget.take(late, ~std::uint64_t{0}));
  EXPECT_TRUE(budget.take(late, 8));
}

TEST(MemoryBudget, lets_one_be_larger_while_the_others_have_at_most_half) {
  MemoryBudget budget(128, 10'000);
  Holder large, small, other, little;
  EXPECT_TRUE(budget.take(small, 40));
  EXPECT_TRUE(budget.take(large, 1000));
  EXPECT_TRUE(budget.take(small, 8));
  EXPECT_FALSE(budget.take(small, 1));
  EXPECT_FALSE(budget.charge(1));
  EXPECT_FALSE(budget.take(other, 1000));
  // Of that half too the last is for small holders.
  EXPECT_TRUE(budget.take(little, 8));
  budget.keep(little, 0);
  // It may grow, since the others cannot.
  EXPECT_TRUE(budget.take(large, 1000));
  budget.keep(small, 0);
  EXPECT_TRUE(budget.take(other, 40));
  // What it keeps fits beside the others: now another may exceed the budget.
  budget.keep(large, 30);
  EXPECT_TRUE(budget.take(other, 500));
  EXPECT_FALSE(budget.take(large, 19));
  EXPECT_TRUE(budget.take(large, 18));
}

TEST(MemoryBudget, serves_waiting_requests_in_their_order_and_small_ones_at_once) {
  MemoryBudget budget(128, 10'000);
  Holder first, second, third, small;
  ASSERT_TRUE(budget.take(first, 100));
  std::thread waiter([&] {
    EXPECT_TRUE(budget.wait(second, 1000, Deadline::never()));
    budget.keep(second, 0);
  });
  while (!budget.is_wanted(3)) std::this_thread::yield();
  EXPECT_FALSE(budget.is_wanted(2));
  EXPECT_FALSE(budget.take(third, 9)) << "the second waits";
  EXPECT_TRUE(budget.take(small, 8));
  EXPECT_FALSE(budget.wait(third, 9, Deadline::in(std::chrono::milliseconds(1))));
  budget.keep(first, 0);
  waiter.join();
  EXPECT_TRUE(budget.take(third, 100));
}

TEST(RequestMemory, has_its_first_bytes_for_nothing) {
  MemoryBudget budget(kMib, 4 * kMib);
  RequestMemory::Plan plan;
  RequestMemory large(budget, plan, Wait::kNever, nullptr);
  EXPECT_TRUE(large.reserve(256 * kKib).ok());
  EXPECT_EQ(budget.taken(), 0U);
  EXPECT_TRUE(is_busy(large.reserve(1))) << "the event loop takes free bytes alone";
  large.keep(100 * kKib);
  EXPECT_TRUE(large.reserve(156 * kKib).ok());
}

TEST(RequestMemory, refuses_what_never_fits) {
  MemoryBudget budget(kMib, 4 * kMib);
  RequestMemory::Plan plan;
  RequestMemory memory(budget, plan, Wait::kWhileEmpty, nullptr);
  EXPECT_TRUE(memory.reserve(4 * kMib).ok());
  for (const std::uint64_t bytes : {257 * kKib, ~std::uint64_t{0}}) {
    const Status refused = memory.reserve(bytes);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "REQUEST_TOO_LARGE");
    EXPECT_EQ(refused.error().kind, ErrorKind::kTooLarge);
  }
  EXPECT_TRUE(memory.reserve(256 * kKib).ok());
}

TEST(RequestMemory, begins_again_with_all_that_it_needs) {
  MemoryBudget budget(8 * kMib, 100 * kMib);
  Holder other;
  ASSERT_TRUE(budget.take(other, 5 * kMib));
  RequestMemory::Plan plan;
  {
    RequestMemory memory(budget, plan, Wait::kWhileEmpty, nullptr);
    ASSERT_TRUE(memory.reserve(kMib).ok());
    EXPECT_TRUE(is_busy(memory.reserve(4 * kMib))) << "it does not wait while it holds memory";
    EXPECT_TRUE(memory.was_refused());
  }
  EXPECT_EQ(budget.taken(), 5 * kMib);
  std::thread again([&] {
    RequestMemory memory(budget, plan, Wait::kWhileEmpty, nullptr);
    EXPECT_TRUE(memory.reserve(kMib).ok());
    EXPECT_GE(budget.taken(), 4 * kMib);
    memory.keep(0);
    EXPECT_TRUE(memory.reserve(5 * kMib).ok());
    memory.finish(0);
    EXPECT_EQ(budget.taken(), 0U);
  });
  while (!budget.is_wanted(kMib)) std::this_thread::yield();
  budget.keep(other, 0);
  again.join();
}

TEST(RequestMemory, knows_whether_others_wait_for_it) {
  MemoryBudget budget(8 * kMib, 100 * kMib);
  RequestMemory::Plan plans[3];
  RequestMemory large(budget, plans[0], Wait::kWhileEmpty, nullptr),
      little(budget, plans[1], Wait::kWhileEmpty, nullptr);
  ASSERT_TRUE(large.reserve(7 * kMib).ok());
  ASSERT_TRUE(little.reserve(300 * kKib).ok());
  EXPECT_FALSE(large.keeps_others_waiting());
  std::thread waiter([&] {
    RequestMemory next(budget, plans[2], Wait::kWhileEmpty, nullptr);
    EXPECT_TRUE(next.reserve(7 * kMib).ok());
  });
  while (!large.keeps_others_waiting()) std::this_thread::yield();
  EXPECT_FALSE(little.keeps_others_waiting());
  large.keep(0);
  waiter.join();
  EXPECT_FALSE(large.keeps_others_waiting());
}

TEST(RequestMemory, waits_no_longer_than_its_request_may_take) {
  MemoryBudget budget(kMib, 100 * kMib);
  Holder other;
  ASSERT_TRUE(budget.take(other, 2 * kMib));
  RequestMemory::Plan plan;
  RequestMemory memory(budget, plan, Wait::kWhileEmpty, nullptr);
  memory.wait_until(Deadline::Clock::now() + std::chrono::milliseconds(20));
  const Status status = memory.reserve(2 * kMib);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, "DEADLINE");
}

TEST(RequestMemory, retains_pinned_bytes) {
  MemoryBudget budget(kMib, 100 * kMib);
  RequestMemory::Plan plan;
  RequestMemory memory(budget, plan, Wait::kStream, nullptr);
  ASSERT_TRUE(memory.pin(300 * kKib).ok());
  memory.keep(0);
  EXPECT_EQ(budget.taken(), 44 * kKib);
  memory.unpin();
  memory.keep(0);
  EXPECT_EQ(budget.taken(), 0U);
}

}  // namespace
}  // namespace sightline
