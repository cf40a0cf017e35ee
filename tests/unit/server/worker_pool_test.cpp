#include "server/http/worker_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/http/connection.h"

namespace sightline {
namespace {

/// One worker, and clients that ask again as soon as they are answered. Names the client of each request
/// in the order of service.
class FairQueue : public testing::Test {
 protected:
  Connection& client(const std::string& name, const std::string& key = {}, double expected = 0) {
    clients_.push_back(std::make_unique<Connection>(-1, budget_, spool_));
    clients_.back()->head.target = name;
    clients_.back()->head.key_name = key;
    clients_.back()->expected = expected;
    return *clients_.back();
  }

  /// Serves so many requests; each that is called "slow" takes ten times as long as any other.
  std::vector<std::string> serve(std::size_t count) {
    std::unique_lock hold(mutex_);
    WorkerPool pool(
        {.threads = 1, .queue = 100, .clock = [&] { return time_.load(); }},
        [&](Connection& connection) {
          // All have come before the first is served.
          while (!begun_) std::this_thread::yield();
          time_ = time_ + (connection.head.target == "slow" ? 10 : 1);
        },
        [&](Connection& connection) {
          const std::lock_guard again(mutex_);
          if (served_.size() == count) return;
          served_.push_back(connection.head.target);
          if (served_.size() == count) done_.notify_one();
          EXPECT_TRUE(pool_->submit(connection));
        });
    pool_ = &pool;
    for (const auto& connection : clients_) EXPECT_TRUE(pool.submit(*connection));
    begun_ = true;
    done_.wait(hold, [&] { return served_.size() == count; });
    hold.unlock();
    return served_;
  }

  static std::ptrdiff_t count(const std::vector<std::string>& served, const std::string& name) {
    return std::count(served.begin(), served.end(), name);
  }

 private:
  MemoryBudget budget_{0, 0};
  Spool spool_{"/tmp", 0};
  std::vector<std::unique_ptr<Connection>> clients_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::atomic<bool> begun_{false};
  std::atomic<double> time_{0};  ///< passes only while a request is served
  WorkerPool* pool_ = nullptr;
  std::vector<std::string> served_;
};

TEST_F(FairQueue, serves_a_connection_of_quick_requests_more_often_than_one_of_slow_requests) {
  for (int i = 0; i < 20; ++i) client("slow");
  client("quick");
  const auto served = serve(100);
  // In the order of arrival it would be served four times.
  EXPECT_GE(count(served, "quick"), 15);
}

TEST_F(FairQueue, gives_a_key_with_many_connections_no_more_than_another_key) {
  for (int i = 0; i < 20; ++i) client("many", "many");
  client("one", "one");
  const auto served = serve(60);
  EXPECT_GE(count(served, "one"), 15);
  EXPECT_GE(count(served, "many"), 15);
}

TEST_F(FairQueue, counts_what_a_key_has_had_since_its_requests_came) {
  for (int i = 0; i < 80; ++i) client("many", "many");
  client("one", "one");
  EXPECT_GE(count(serve(60), "one"), 15);
}

TEST_F(FairQueue, serves_first_what_is_expected_to_take_less) {
  for (int i = 0; i < 20; ++i) client("slow", {}, 10);
  client("quick", {}, 1);
  const auto served = serve(30);
  // In the order of arrival it would be the last.
  EXPECT_LT(std::find(served.begin(), served.end(), "quick") - served.begin(), 3);
  EXPECT_GE(count(served, "slow"), 10);
}

TEST_F(FairQueue, serves_what_is_expected_to_take_long_beside_others_that_always_wait) {
  client("slow", {}, 10);
  for (int i = 0; i < 5; ++i) client("quick", {}, 1);
  EXPECT_GE(count(serve(200), "slow"), 2);
}

TEST_F(FairQueue, serves_equal_connections_in_turns) {
  for (const char* name : {"a", "b", "c"}) client(name);
  const auto served = serve(60);
  for (const char* name : {"a", "b", "c"}) EXPECT_GE(count(served, name), 12) << name;
}

TEST(WorkerPool, leaves_half_of_its_threads_to_what_is_not_slow) {
  MemoryBudget budget(0, 0);
  Spool spool("/tmp", 0);
  std::vector<std::unique_ptr<Connection>> slow;
  for (int i = 0; i < 5; ++i) {
    slow.push_back(std::make_unique<Connection>(-1, budget, spool));
    slow.back()->expected = Connection::kUnknown + 1;
  }
  Connection quick(-1, budget, spool), one_more(-1, budget, spool);
  one_more.expected = Connection::kUnknown + 1;
  quick.expected = Connection::kUnknown;
  std::atomic<bool> go_on{false};
  std::atomic<int> begun{0}, slow_ended{0};
  std::atomic<bool> quick_ended{false};
  const auto soon = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto until = [&](const auto& is_true) {
    while (!is_true() && std::chrono::steady_clock::now() < soon) std::this_thread::yield();
    return is_true();
  };
  {
    WorkerPool pool(
        {.threads = 4, .queue = 3},
        [&](Connection& connection) {
          if (&connection == &quick) return;
          ++begun;
          while (!go_on) std::this_thread::yield();
        },
        [&](Connection& connection) {
          if (&connection == &quick) quick_ended = true;
          if (&connection != &quick) ++slow_ended;
        });
    for (const auto& connection : slow) EXPECT_TRUE(pool.submit(*connection));
    EXPECT_TRUE(until([&] { return begun == 2; }));
    EXPECT_FALSE(pool.submit(one_more)) << "three wait";
    EXPECT_TRUE(pool.submit(quick));
    EXPECT_TRUE(until([&] { return quick_ended.load(); }));
    EXPECT_EQ(begun, 2);
    EXPECT_EQ(pool.queued(), 3u);
    go_on = true;
  }
  EXPECT_EQ(slow_ended, 5);  // the destructor waits for those that had to wait
}

TEST(WorkerPool, takes_as_many_as_may_wait_and_no_more) {
  MemoryBudget budget(0, 0);
  Spool spool("/tmp", 0);
  Connection first(-1, budget, spool), second(-1, budget, spool), third(-1, budget, spool);
  std::atomic<bool> go_on{false};
  WorkerPool pool(
      {.threads = 1, .queue = 1},
      [&](Connection&) {
        while (!go_on) std::this_thread::yield();
      },
      [](Connection&) {});
  EXPECT_TRUE(pool.submit(first));
  EXPECT_TRUE(pool.submit(second));
  EXPECT_FALSE(pool.submit(third));
  go_on = true;
}

}  // namespace
}  // namespace sightline
