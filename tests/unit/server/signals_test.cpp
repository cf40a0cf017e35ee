// Signals as events.

#include "server/operation/signals.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sightline {
namespace {

using Event = Signals::Event;
constexpr std::chrono::milliseconds kNow{0};

TEST(Signals, are_events_in_their_order) {
  Signals signals;
  EXPECT_EQ(signals.wait(kNow), Event::kTimeout);
  // To this thread alone: other tests have left threads that do not block these signals.
  ::raise(SIGHUP);
  EXPECT_EQ(signals.wait(std::nullopt), Event::kReload);
  ::raise(SIGTERM);
  EXPECT_EQ(signals.wait(std::nullopt), Event::kStop);
  ::raise(SIGINT);
  EXPECT_EQ(signals.wait(std::nullopt), Event::kStop);
}

TEST(Signals, wake_ends_one_wait) {
  Signals signals;
  signals.wake();
  EXPECT_EQ(signals.wait(std::nullopt), Event::kWoken);
  EXPECT_EQ(signals.wait(kNow), Event::kTimeout);
}

TEST(SignalsDeathTest, one_that_is_let_through_ends_the_process) {
  for (const int number : {SIGTERM, SIGINT}) {
    EXPECT_EXIT(
        {
          Signals signals;
          ::kill(::getpid(), number);
          signals.wait(std::nullopt);
          signals.let_through();
          ::pause();
        },
        testing::KilledBySignal(number), "");
  }
}

TEST(Signals, let_through_returns_where_no_signal_ends_the_process) {
  constexpr int kNoRoot = 77;
  const pid_t outer = ::fork();
  if (outer == 0) {
    if (::unshare(CLONE_NEWPID) != 0) ::_exit(kNoRoot);
    const pid_t first = ::fork();
    if (first == 0) {
      Signals signals;
      ::kill(::getpid(), SIGTERM);
      signals.wait(std::nullopt);
      ::_exit(signals.let_through());
    }
    int status = 0;
    ::waitpid(first, &status, 0);
    ::_exit(WIFEXITED(status) ? WEXITSTATUS(status) : 0);
  }
  int status = 0;
  ::waitpid(outer, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoRoot) GTEST_SKIP() << "only root makes a process the first one";
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM);
}

}  // namespace
}  // namespace sightline
