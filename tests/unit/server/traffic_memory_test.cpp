#include "server/traffic_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "server/connection.h"
#include "server/work_memory.h"

namespace sightline {
namespace {

TEST(TrafficMemory, bounds_the_sum) {
  TrafficMemory memory(100);
  TrafficMemory::Holder a, b;
  EXPECT_TRUE(memory.take(&a, 30));
  EXPECT_TRUE(memory.take(&b, 40));
  EXPECT_TRUE(memory.take(nullptr, 30));
  // Each has others beside it that hold more than half.
  EXPECT_FALSE(memory.take(&a, 1));
  EXPECT_FALSE(memory.take(&b, 1));
  EXPECT_FALSE(memory.take(nullptr, 1));
  memory.give(nullptr, 30);
  EXPECT_TRUE(memory.take(&a, 30));
  EXPECT_FALSE(memory.take(nullptr, 1));
}

TEST(TrafficMemory, lets_one_be_larger_while_the_others_have_no_more_than_half) {
  TrafficMemory memory(100);
  TrafficMemory::Holder large, small, other;
  EXPECT_TRUE(memory.take(&small, 40));
  EXPECT_TRUE(memory.take(&large, 1000));
  EXPECT_TRUE(memory.take(nullptr, 10));
  EXPECT_FALSE(memory.take(nullptr, 1));
  EXPECT_FALSE(memory.take(&small, 1));
  EXPECT_FALSE(memory.take(&other, 1000));
  // It may grow, since the others cannot.
  EXPECT_TRUE(memory.take(&large, 1000));
  EXPECT_FALSE(memory.take(&large, ~std::uint64_t{0}));
  memory.give(&small, 40);
  EXPECT_TRUE(memory.take(&other, 40));
  // What it keeps fits beside the others: now another may be the one.
  memory.give(&large, 1970);
  EXPECT_TRUE(memory.take(&other, 20));
  memory.give(nullptr, 10);
  EXPECT_TRUE(memory.take(&other, 500));
  EXPECT_FALSE(memory.take(&large, 21));
  EXPECT_TRUE(memory.take(&large, 20));
}

TEST(TrafficMemory, tells_one_at_a_time_to_give_way_where_all_wait_for_each_other) {
  TrafficMemory memory(100);
  TrafficMemory::Holder a, b, at_work, nothing;
  ASSERT_TRUE(memory.take(&a, 60) && memory.take(&b, 30) && memory.take(&at_work, 10));
  TrafficMemory::Waiter first(memory, a), second(memory, b), third(memory, nothing);
  // One is at work and will give back.
  EXPECT_FALSE(first.gives_way(50));
  memory.give(&at_work, 10);
  EXPECT_FALSE(third.gives_way(50));
  EXPECT_TRUE(second.gives_way(30));
  // The other waits for what that one gives back, and then for nobody.
  EXPECT_FALSE(first.gives_way(50));
  memory.give(&b, 30);
  EXPECT_FALSE(first.gives_way(60));
}

TEST(TrafficMemory, is_what_buffers_bodies_and_work_are_taken_of) {
  TrafficMemory traffic(100);
  WorkMemory bodies(traffic, 60, 1000), work(traffic, 60, 1000);
  ByteBudget buffers(traffic, 60);
  TrafficMemory::Holder one, two;
  WorkMemory::Share body(bodies, one), large(work, one), small(work, two);
  EXPECT_TRUE(buffers.charge(50));
  EXPECT_FALSE(buffers.charge(11));  // of the buffers' own
  EXPECT_TRUE(body.grow(30).ok());
  EXPECT_TRUE(small.grow(20).ok());
  EXPECT_FALSE(buffers.charge(1));
  EXPECT_EQ(small.grow(1).error().code, "MEMORY_BUSY");
  buffers.release(40);
  // Beyond the sum by one request, with its body and its work.
  EXPECT_TRUE(large.grow(500).ok());
  EXPECT_TRUE(body.grow(100).ok());
  EXPECT_TRUE(small.grow(20).ok());
  EXPECT_FALSE(small.grow(1).ok());
  EXPECT_FALSE(buffers.charge(1));
  // Of a part that is on its way little is counted as work, and all with the traffic.
  large.keep(10, 490);
  EXPECT_FALSE(buffers.charge(1));
  large.keep(0);
  body.keep(0);
  EXPECT_TRUE(buffers.charge(50));
}

TEST(TrafficMemory, makes_who_waits_for_each_other_give_way) {
  TrafficMemory traffic(100);
  WorkMemory work(traffic, 1000, 1000);
  std::atomic<int> good{0}, busy{0};
  TrafficMemory::Holder holders[3];
  WorkMemory::Share a(work, holders[0]), b(work, holders[1]), c(work, holders[2]);
  WorkMemory::Share* const shares[] = {&a, &b, &c};
  for (WorkMemory::Share* share : shares) ASSERT_TRUE(share->grow(30).ok());
  std::vector<std::thread> waiters;
  for (WorkMemory::Share* share : shares) {
    waiters.emplace_back([&, share] {
      const Status status = share->wait(60, Deadline::never());
      ++(status ? good : busy);
      share->keep(0);
    });
  }
  for (std::thread& waiter : waiters) waiter.join();
  EXPECT_EQ(good, 2);
  EXPECT_EQ(busy, 1);
}

}  // namespace
}  // namespace sightline
