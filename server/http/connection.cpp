#include "server/http/connection.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/sendfile.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <limits>

namespace sightline {

bool send_pending(Connection& connection, std::uint64_t most, bool& full) {
  full = false;
  std::uint64_t sent = 0;
  while (connection.has_output() && sent < most) {
    ssize_t count = 0;
    if (connection.pending_output() > 0) {
      count = ::send(connection.socket, connection.output.data() + connection.sent,
                     connection.pending_output(), MSG_NOSIGNAL | MSG_DONTWAIT);
    } else {
      auto offset = static_cast<off_t>(connection.file_sent);
      const auto size = static_cast<std::size_t>(std::min(connection.pending_file(), most - sent));
      count = ::sendfile(connection.socket, connection.output_file->descriptor(), &offset, size);
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      full = true;
      return true;
    }
    if (count <= 0) return false;
    const auto bytes = static_cast<std::size_t>(count);
    (connection.pending_output() > 0 ? connection.sent : connection.file_sent) += bytes;
    connection.given += bytes;
    sent += bytes;
  }
  if (connection.pending_output() == 0) {
    if (connection.output.capacity() > (64 << 10)) std::string().swap(connection.output);
    connection.output.clear();
    connection.sent = 0;
  }
  if (connection.pending_file() == 0) {
    connection.output_file.reset();
    connection.file_sent = 0;
  }
  return true;
}

bool send_pending(Connection& connection) {
  bool full = false;
  return send_pending(connection, std::numeric_limits<std::uint64_t>::max(), full);
}

std::uint64_t send_buffer_bytes(const Connection& connection) {
  int bytes = 0;
  if (::ioctl(connection.socket, SIOCOUTQ, &bytes) != 0 || bytes < 0) return 0;
  return static_cast<std::uint64_t>(bytes);
}

std::uint64_t taken_by_client(const Connection& connection) {
  return connection.given - std::min(connection.given, send_buffer_bytes(connection));
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

bool take_body(Connection& connection, std::size_t most) {
  const std::size_t size = std::min(connection.pending_input().size(), most);
  std::size_t taken = 0;
  const bool good = connection.body->take(connection.input.data() + connection.taken, size, taken);
  connection.take(taken);
  return good;
}

}  // namespace sightline
