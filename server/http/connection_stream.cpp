#include "server/http/connection_stream.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace sightline {
namespace {

constexpr std::size_t kCollected = 16 << 10;
/// What every connection may leave behind in memory, whatever others hold; and what it may where
/// the budget has room.
constexpr std::size_t kFreeOutput = 4 << 10, kMostOutput = 64 << 10;

bool wait_for(int socket, short events, std::chrono::steady_clock::time_point due) {
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(due - std::chrono::steady_clock::now());
    pollfd wanted{socket, events, 0};
    const int ready =
        ::poll(&wanted, 1, static_cast<int>(std::clamp<long long>(left.count(), 0, 3'600'000)));
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0;
  }
}

}  // namespace

bool wait_until_readable(int socket, std::chrono::steady_clock::time_point due) {
  return wait_for(socket, POLLIN, due);
}

ssize_t ConnectionStream::read(char* data, std::size_t size) {
  const std::size_t count = unread_.copy(data, size);
  unread_.remove_prefix(count);
  return static_cast<ssize_t>(count);
}

bool ConnectionStream::send_with(std::string_view& more) {
  while (connection_.pending_output() > 0 || !more.empty()) {
    const std::size_t before = connection_.pending_output();
    iovec parts[2] = {{connection_.output.data() + connection_.sent, before},
                      {const_cast<char*>(more.data()), more.size()}};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    const ssize_t count = ::sendmsg(connection_.socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (count <= 0) return false;
    const auto sent = static_cast<std::size_t>(count);
    connection_.given += sent;
    connection_.sent += std::min(sent, before);
    more.remove_prefix(sent - std::min(sent, before));
  }
  return true;
}

bool ConnectionStream::spool(std::string_view rest) {
  if (!connection_.output_file) {
    connection_.output_file = std::make_unique<SpoolFile>(connection_.spool);
  }
  SpoolFile& file = *connection_.output_file;
  // The output is sent before the file: it is empty from the file's first byte on.
  if (!file.append(std::string_view(connection_.output).substr(connection_.sent))) {
    if (file.size() == 0) connection_.output_file.reset();
    return false;
  }
  std::string().swap(connection_.output);
  connection_.sent = 0;
  return file.append(rest);
}

bool ConnectionStream::leave_behind(std::string_view rest) {
  const std::size_t size = connection_.pending_output() + rest.size();
  const auto fits = [&] {
    if (size <= kFreeOutput || size <= connection_.charged) return true;
    if (!connection_.budget.charge(size - connection_.charged)) return false;
    connection_.charged = size;
    return true;
  };
  if (!connection_.output_file) {
    // Where the spool is full, memory may do.
    const bool stays = size <= kMostOutput && fits();
    if (!stays && spool(rest)) return true;
    if (!stays && (connection_.output_file || !fits())) return false;
    connection_.output.erase(0, connection_.sent);
    connection_.sent = 0;
    connection_.output.append(rest);
    return true;
  }
  return spool(rest);
}

void ConnectionStream::Uptake::look(const Connection& connection) {
  const std::uint64_t before = std::exchange(taken, taken_by_client(connection));
  const Pace::Clock::time_point now = Pace::Clock::now();
  pace.moved(taken - before, now);
  hurry.moved(taken - before, now);
}

bool ConnectionStream::wait_for_client(Uptake& uptake) {
  while (!connection_.gone.cancelled()) {
    uptake.look(connection_);
    const Pace::Clock::time_point now = Pace::Clock::now();
    const auto due = uptake.pace.due();
    if (now >= uptake.hurry.due() && memory_ != nullptr && memory_->keeps_others_waiting())
      return false;
    if (wait_for(connection_.socket, POLLOUT, std::min(due, now + kSlowClientLook))) return true;
    if (now >= due) return false;
  }
  return false;
}

void ConnectionStream::collect_head(std::string_view head) {
  const std::size_t line = head.find("\r\n");
  const std::size_t end = line == std::string_view::npos ? 0 : line + 2;
  connection_.output.append(head.substr(0, end)).append(head_lines_).append(head.substr(end));
  head_lines_.clear();
}

ssize_t ConnectionStream::write(const char* data, std::size_t size) {
  if (broken_) return -1;
  if (silent_) return static_cast<ssize_t>(size);
  if (!head_lines_.empty()) {
    collect_head({data, size});
    return static_cast<ssize_t>(size);
  }
  if (connection_.output_file) {
    broken_ = !spool({data, size});
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  if (connection_.pending_output() + size <= kCollected) {
    connection_.output.append(data, size);
    return static_cast<ssize_t>(size);
  }
  std::string_view rest(data, size);
  broken_ = !send_with(rest);
  if (broken_ || rest.empty()) {
    if (connection_.pending_output() == 0) {
      connection_.output.clear();
      connection_.sent = 0;
    }
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  if (!connection_.streams) {
    broken_ = !leave_behind(rest);
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  Uptake uptake(connection_, pace_limits_, hurry_limits_);
  while (!rest.empty() && !broken_) broken_ = !wait_for_client(uptake) || !send_with(rest);
  return broken_ ? -1 : static_cast<ssize_t>(size);
}

bool ConnectionStream::flush() {
  Uptake uptake(connection_, pace_limits_, pace_limits_);
  while (!broken_) {
    broken_ = !send_pending(connection_);
    if (broken_ || connection_.pending_output() == 0) break;
    broken_ = !wait_for_client(uptake);
  }
  return !broken_;
}

bool ConnectionStream::finish() {
  bool full = false;
  broken_ = broken_ || !send_pending(connection_, kMostOutput, full) ||
            (connection_.pending_output() > 0 && !leave_behind({}));
  return !broken_;
}

// Nobody asks for either, and they would cost a system call for every request.
void ConnectionStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  get_local_ip_and_port(ip, port);
}

void ConnectionStream::get_local_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

// The library asks only to refuse what select() could not hold. We poll, and take any number.
socket_t ConnectionStream::socket() const { return 0; }

}  // namespace sightline
