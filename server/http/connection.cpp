#include "server/http/connection.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace sightline {

bool send_pending(Connection& connection) {
  while (connection.pending_output() > 0) {
    const ssize_t count = ::send(connection.socket, connection.output.data() + connection.sent,
                                 connection.pending_output(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (count <= 0) return false;
    connection.sent += static_cast<std::size_t>(count);
    connection.given += static_cast<std::size_t>(count);
  }
  if (connection.output.capacity() > (64 << 10)) std::string().swap(connection.output);
  connection.output.clear();
  connection.sent = 0;
  return true;
}

std::uint64_t taken_by_client(const Connection& connection) {
  int waiting = 0;
  if (::ioctl(connection.socket, SIOCOUTQ, &waiting) != 0 || waiting < 0) return connection.given;
  return connection.given - std::min(connection.given, static_cast<std::uint64_t>(waiting));
}

Received receive_at(Connection& connection, char* data, std::size_t size, std::size_t& count) {
  count = 0;
  for (;;) {
    const ssize_t received = ::recv(connection.socket, data, size, MSG_DONTWAIT);
    if (received < 0 && errno == EINTR) continue;
    if (received < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Received::kNothing;
    if (received <= 0) return Received::kEnd;
    count = static_cast<std::size_t>(received);
    // What comes after a short one is told by a new edge: epoll(7).
    return count < size ? Received::kAll : Received::kSome;
  }
}

Received receive_some(Connection& connection, std::size_t most) {
  // On the stack and not in each connection: thousands of them may be idle.
  std::array<char, 32 << 10> buffer;
  std::size_t count = 0;
  // Here, because there may never be a moment when all is taken: a client can always have begun the
  // next request.
  connection.input.erase(0, connection.taken);
  connection.taken = 0;
  const Received received =
      receive_at(connection, buffer.data(), std::min(most, buffer.size()), count);
  connection.input.append(buffer.data(), count);
  return received;
}

}  // namespace sightline
