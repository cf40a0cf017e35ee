#include "server/http/connection.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace sightline {
namespace {

TEST(Connection, holds_what_it_waits_for_and_not_what_was_taken) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  MemoryBudget budget(0, 0);
  Spool spool("/tmp", 0);
  Connection connection(ends[0], budget, spool);
  // The rest of a request and the first half of the next, always: at no moment all is taken.
  const std::string request = std::string(500, 'a') + std::string(500, 'b');
  ASSERT_EQ(::send(ends[1], request.data(), 500, 0), 500);
  const std::string turned = request.substr(500) + request.substr(0, 500);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(::send(ends[1], turned.data(), turned.size(), 0), 1000);
    while (connection.pending_input().size() < 1500) {
      ASSERT_NE(receive_some(connection, 16 << 10), Received::kEnd);
    }
    EXPECT_EQ(connection.pending_input().substr(0, 1000), request);
    connection.take(1000);
  }
  EXPECT_LT(connection.input.capacity(), std::size_t{8} << 10);
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(Connection, gives_back_what_it_was_charged_for_when_all_is_taken) {
  MemoryBudget budget(200, 0);
  Spool spool("/tmp", 0);
  Connection connection(-1, budget, spool);
  connection.input = "body";
  ASSERT_TRUE(budget.charge(60));
  connection.charged = 60;
  connection.take(3);
  EXPECT_EQ(budget.taken(), 60U);
  connection.take(1);
  EXPECT_EQ(budget.taken(), 0U);
}

TEST(Pace, does_not_count_a_pause) {
  using namespace std::chrono_literals;
  PaceLimits limits;
  limits.window = 5000ms;
  limits.longest = 8000ms;
  const Pace::Clock::time_point begin{};
  Pace pace(limits, begin);
  EXPECT_EQ(pace.due(), begin + 5s);
  pace.pause(10s);
  EXPECT_EQ(pace.due(), begin + 15s);
  pace.moved(1 << 20, begin + 14s);
  EXPECT_EQ(pace.due(), begin + 18s);
  // Who keeps only the pace has no end to pause.
  pace.restart(begin + 14s);
  pace.pause(1s);
  EXPECT_EQ(pace.due(), begin + 20s);
}

TEST(Pace, is_kept_by_whoever_sends_at_the_rate_however_it_is_cut) {
  using namespace std::chrono_literals;
  PaceLimits limits;
  limits.bytes_per_second = 4096;
  limits.window = 5000ms;
  limits.longest = 10'000'000ms;
  const Pace::Clock::time_point begin{};
  Pace pace(limits, begin);
  // 5.0 kB/s in pieces of one second: every piece arrives before the pace is too slow.
  for (int second = 1; second <= 1000; ++second) {
    const auto now = begin + std::chrono::seconds(second);
    ASSERT_LT(now, pace.due()) << second;
    pace.moved(5000, now);
  }
  // A burst pays for one window and not for more.
  pace.moved(100 << 20, begin + 1001s);
  EXPECT_EQ(pace.due(), begin + 1006s);
  pace.moved(1, begin + 1005s);
  EXPECT_LT(pace.due(), begin + 1007s);
}

}  // namespace
}  // namespace sightline
