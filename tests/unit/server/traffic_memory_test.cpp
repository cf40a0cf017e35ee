#include "server/http/traffic_memory.h"

#include <gtest/gtest.h>

#include <thread>

#include "server/http/connection.h"
#include "server/http/work_memory.h"

namespace sightline {
namespace {

TEST(TrafficMemory, bounds_the_sum) {
  TrafficMemory memory(128);  // the last 16 are kept for who has no more than 8
  TrafficMemory::Holder a, b;
  EXPECT_TRUE(memory.take(&a, 42));
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

TEST(TrafficMemory, keeps_some_for_who_has_little) {
  TrafficMemory memory(128);
  TrafficMemory::Holder large, little, next, late;
  EXPECT_TRUE(memory.take(&large, 62));
  EXPECT_TRUE(memory.take(nullptr, 50));
  EXPECT_TRUE(memory.take(&little, 8));
  EXPECT_FALSE(memory.take(&little, 1));
  EXPECT_TRUE(memory.take(&next, 8));
  EXPECT_FALSE(memory.take(&late, 1));
  memory.give(&little, 8);
  EXPECT_FALSE(memory.take(&late, ~std::uint64_t{0}));
  EXPECT_TRUE(memory.take(&late, 8));
}

TEST(TrafficMemory, lets_one_be_larger_while_the_others_have_no_more_than_half) {
  TrafficMemory memory(128);
  TrafficMemory::Holder large, small, other, little;
  EXPECT_TRUE(memory.take(&small, 40));
  EXPECT_TRUE(memory.take(&large, 1000));
  EXPECT_TRUE(memory.take(nullptr, 8));
  EXPECT_FALSE(memory.take(nullptr, 1));
  EXPECT_FALSE(memory.take(&small, 1));
  EXPECT_FALSE(memory.take(&other, 1000));
  // Of that half too the last is kept for who has little.
  EXPECT_TRUE(memory.take(&little, 8));
  memory.give(&little, 8);
  // It may grow, since the others cannot.
  EXPECT_TRUE(memory.take(&large, 1000));
  EXPECT_FALSE(memory.take(&large, ~std::uint64_t{0}));
  memory.give(&small, 40);
  EXPECT_TRUE(memory.take(&other, 40));
  // What it keeps fits beside the others: now another may be the one.
  memory.give(&large, 1970);
  EXPECT_TRUE(memory.take(&other, 34));
  memory.give(nullptr, 8);
  EXPECT_TRUE(memory.take(&other, 500));
  EXPECT_FALSE(memory.take(&large, 19));
  EXPECT_TRUE(memory.take(&large, 18));
}

TEST(TrafficMemory, is_what_buffers_bodies_and_work_are_taken_of) {
  TrafficMemory traffic(128);
  WorkMemory bodies(traffic, 80, 1000), work(traffic, 80, 1000);
  ByteBudget buffers(traffic, 60);
  TrafficMemory::Holder one, two;
  WorkMemory::Share body(bodies, one), large(work, one), small(work, two);
  EXPECT_TRUE(buffers.charge(50));
  EXPECT_FALSE(buffers.charge(11));  // of the buffers' own
  EXPECT_TRUE(body.grow(40).ok());
  EXPECT_TRUE(small.grow(22).ok());
  EXPECT_FALSE(buffers.charge(1));
  EXPECT_EQ(small.grow(1).error().code, "MEMORY_BUSY");
  buffers.release(40);
  // Beyond the sum by one request, with its body and its work.
  EXPECT_TRUE(large.grow(500).ok());
  EXPECT_TRUE(body.grow(100).ok());
  EXPECT_TRUE(small.grow(16).ok());
  EXPECT_FALSE(small.grow(1).ok());
  EXPECT_FALSE(buffers.charge(1));
  // Of a part that is on its way little is counted as work, and all with the traffic.
  large.keep(10, 490);
  EXPECT_FALSE(buffers.charge(1));
  large.keep(0);
  body.keep(0);
  EXPECT_TRUE(buffers.charge(50));
}

/// Waits for `bytes` more on a thread of its own, and gives all back when it has been told.
class Waiting {
 public:
  Waiting(WorkMemory::Share& share, std::uint64_t bytes)
      : thread_([this, &share, bytes] {
          has_grown_ = share.wait(bytes, Deadline::never()).ok();
          share.keep(0);
        }) {}
  bool has_grown() {
    thread_.join();
    return has_grown_;
  }

 private:
  bool has_grown_ = false;
  std::thread thread_;
};

TEST(TrafficMemory, makes_who_waits_for_each_other_give_way) {
  TrafficMemory traffic(128);
  WorkMemory work(traffic, 1000, 1000);
  TrafficMemory::Holder holders[3];
  WorkMemory::Share a(work, holders[0]), b(work, holders[1]), c(work, holders[2]);
  for (WorkMemory::Share* share : {&a, &b, &c}) ASSERT_TRUE(share->grow(36).ok());
  Waiting first(a, 60), second(b, 60), third(c, 60);
  EXPECT_EQ(first.has_grown() + second.has_grown() + third.has_grown(), 2);
}

TEST(TrafficMemory, lets_who_waits_for_what_is_sent_wait) {
  TrafficMemory traffic(128);
  WorkMemory bodies(traffic, 1000, 1000), work(traffic, 1000, 1000);
  ByteBudget buffers(traffic, 100);
  TrafficMemory::Holder one, two;
  WorkMemory::Share body(bodies, one), other(work, two);
  ASSERT_TRUE(body.grow(15).ok() && other.grow(15).ok() && buffers.charge(80));
  Waiting first(body, 20), second(other, 20);
  // The later of them has seen then that all wait.
  while (!bodies.is_wanted() || !work.is_wanted()) std::this_thread::yield();
  buffers.release(80);
  EXPECT_TRUE(first.has_grown());
  EXPECT_TRUE(second.has_grown());
}

TEST(TrafficMemory, makes_who_waits_for_what_is_never_sent_give_way) {
  TrafficMemory traffic(128);
  WorkMemory work(traffic, 1000, 1000);
  ByteBudget buffers(traffic, 100);
  TrafficMemory::Holder one, two;
  WorkMemory::Share a(work, one), b(work, two);
  ASSERT_TRUE(a.grow(25).ok() && b.grow(25).ok() && buffers.charge(60));
  Waiting first(a, 20), second(b, 20);
  EXPECT_EQ(first.has_grown() + second.has_grown(), 1);
}

TEST(TrafficMemory, lets_bodies_begin_late_while_those_that_have_begun_wait) {
  TrafficMemory traffic(100);
  constexpr bool kBeginsLate = true;
  WorkMemory bodies(traffic, 1000, 1000, kBeginsLate), work(traffic, 30, 1000);
  TrafficMemory::Holder at_work, begun, new_body, new_work;
  WorkMemory::Share running(work, at_work), first(bodies, begun), decoded(work, begun),
      body(bodies, new_body), other(work, new_work);
  ASSERT_TRUE(running.grow(35).ok() && first.grow(10).ok());
  Waiting waiting(decoded, 70);
  while (!work.is_wanted()) std::this_thread::yield();
  EXPECT_FALSE(body.grow(6).ok());
  {
    TrafficMemory::Holder whole_body;
    WorkMemory::Share whole(bodies, whole_body);
    EXPECT_TRUE(whole.wait(6, Deadline::in(std::chrono::milliseconds(0)), true).ok());
  }
  EXPECT_TRUE(body.grow(5).ok());    // half
  EXPECT_TRUE(body.grow(10).ok());   // it has begun
  EXPECT_TRUE(other.grow(20).ok());  // what ends by itself
  body.keep(0);
  other.keep(0);
  running.keep(0);
  EXPECT_TRUE(waiting.has_grown());
  EXPECT_TRUE(body.grow(90).ok());
}

}  // namespace
}  // namespace sightline
