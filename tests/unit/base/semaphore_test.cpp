#include "core/base/semaphore.h"

#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace sightline {
namespace {

TEST(Semaphore, gives_as_many_permits_as_it_has) {
  Semaphore semaphore(2);
  const Permit first = semaphore.try_acquire();
  std::optional<Permit> second(semaphore.try_acquire());
  EXPECT_TRUE(first);
  EXPECT_TRUE(*second);
  EXPECT_FALSE(semaphore.try_acquire());
  second.reset();
  EXPECT_TRUE(semaphore.try_acquire());
}

TEST(Semaphore, releases_a_moved_permit_once) {
  Semaphore semaphore(1);
  Permit permit = semaphore.try_acquire();
  {
    const Permit moved(std::move(permit));
    EXPECT_TRUE(moved);
    EXPECT_FALSE(semaphore.try_acquire());
  }
  EXPECT_TRUE(semaphore.try_acquire());
  EXPECT_TRUE(semaphore.try_acquire());
}

TEST(Semaphore, loses_no_permit_among_threads) {
  Semaphore semaphore(3);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < 10'000; ++round) const Permit permit = semaphore.try_acquire();
    });
  }
  for (std::thread& thread : threads) thread.join();
  const Permit all[] = {semaphore.try_acquire(), semaphore.try_acquire(), semaphore.try_acquire()};
  for (const Permit& permit : all) EXPECT_TRUE(permit);
  EXPECT_FALSE(semaphore.try_acquire());
}

}  // namespace
}  // namespace sightline
