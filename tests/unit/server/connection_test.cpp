#include "server/connection.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace sightline {
namespace {

TEST(Connection, holds_what_it_waits_for_and_not_what_was_taken) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  TrafficMemory traffic(0);
  ByteBudget budget(traffic, 0);
  Connection connection(ends[0], budget);
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

}  // namespace
}  // namespace sightline
