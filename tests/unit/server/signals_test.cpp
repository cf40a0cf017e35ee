// Signals as events.

#include "server/signals.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace sightline {
namespace {

using Event = Signals::Event;
constexpr std::chrono::milliseconds kNow{0};

TEST(Signals, are_events_in_their_order) {
  Signals signals;
  EXPECT_EQ(signals.wait(kNow), Event::kTimeout);
  ::kill(::getpid(), SIGHUP);
  EXPECT_EQ(signals.wait(std::nullopt), Event::kReload);
  ::kill(::getpid(), SIGTERM);
  EXPECT_EQ(signals.wait(std::nullopt), Event::kStop);
  ::kill(::getpid(), SIGINT);
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

}  // namespace
}  // namespace sightline
