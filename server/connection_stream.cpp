#include "server/connection_stream.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace sightline {
namespace {

constexpr std::size_t kReadBuffer = 16 << 10;
constexpr std::size_t kWriteBuffer = 16 << 10;

bool wait_for(int socket, short events, std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd wanted{socket, events, 0};
    const int ready = ::poll(&wanted, 1, static_cast<int>(std::max<long long>(left.count(), 0)));
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0;
  }
}

void name_of(const sockaddr_storage& address, std::string& ip, int& port) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof v4);
    ::inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
    port = ntohs(v4.sin_port);
  } else if (address.ss_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address, sizeof v6);
    ::inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof text);
    port = ntohs(v6.sin6_port);
  }
  ip = text;
}

using NameCall = int (*)(int, sockaddr*, socklen_t*);

void name_by(NameCall call, int socket, std::string& ip, int& port) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (call(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0) name_of(address, ip, port);
}

}  // namespace

ConnectionStream::ConnectionStream(int socket, Timeouts timeouts)
    : socket_(socket), timeouts_(timeouts), read_buffer_(kReadBuffer) {}

bool ConnectionStream::is_readable() const {
  return has_buffered() || wait_for(socket_, POLLIN, timeouts_.read);
}

bool ConnectionStream::is_writable() const { return wait_for(socket_, POLLOUT, timeouts_.write); }

bool ConnectionStream::fill() {
  // What the client waits for ("100 Continue") must leave before we wait for the client.
  if (!flush() || !wait_for(socket_, POLLIN, timeouts_.read)) return false;
  ssize_t got = 0;
  do {
    got = ::recv(socket_, read_buffer_.data(), read_buffer_.size(), 0);
  } while (got < 0 && errno == EINTR);
  read_at_ = 0;
  read_end_ = got > 0 ? static_cast<std::size_t>(got) : 0;
  return got > 0;
}

ssize_t ConnectionStream::read(char* data, std::size_t size) {
  if (!has_buffered() && !fill()) return 0;
  const std::size_t count = std::min(size, read_end_ - read_at_);
  std::memcpy(data, read_buffer_.data() + read_at_, count);
  read_at_ += count;
  bytes_read_ += count;
  if (in_head_) hide_range(data, count);
  return static_cast<ssize_t>(count);
}

void ConnectionStream::begin_head() {
  in_head_ = true;
  line_size_ = 0;
  may_be_range_ = true;
}

void ConnectionStream::hide_range(char* data, std::size_t size) {
  constexpr std::string_view kName = "range:";
  for (std::size_t i = 0; i < size && in_head_; ++i) {
    const char c = data[i];
    if (c == '\r') continue;
    if (c == '\n') {
      in_head_ = line_size_ > 0;
      line_size_ = 0;
      may_be_range_ = true;
      continue;
    }
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    may_be_range_ = may_be_range_ && line_size_ < kName.size() && lower == kName[line_size_];
    // The letters have been read already; with another byte for the colon they are no longer a name
    // that anybody asks for.
    if (may_be_range_ && c == ':') data[i] = '-';
    ++line_size_;
  }
}

ssize_t ConnectionStream::write(const char* data, std::size_t size) {
  if (write_buffer_.size() + size <= kWriteBuffer) {
    write_buffer_.append(data, size);
    return static_cast<ssize_t>(size);
  }
  // The head goes along with the first part of a large body; the rest is not copied.
  const std::size_t head = kWriteBuffer - std::min(kWriteBuffer, write_buffer_.size());
  write_buffer_.append(data, head);
  if (!flush()) return -1;
  std::size_t sent = head;
  while (sent < size) {
    if (!is_writable()) return -1;
    const ssize_t count = ::send(socket_, data + sent, size - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
    if (count <= 0) return -1;
    sent += static_cast<std::size_t>(count);
  }
  return static_cast<ssize_t>(size);
}

bool ConnectionStream::flush() {
  std::size_t sent = 0;
  while (sent < write_buffer_.size()) {
    const ssize_t count = ::send(socket_, write_buffer_.data() + sent, write_buffer_.size() - sent,
                                 MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      if (!is_writable()) break;
      continue;
    }
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  const bool all = sent == write_buffer_.size();
  write_buffer_.clear();
  return all;
}

void ConnectionStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  name_by(::getpeername, socket_, ip, port);
}

void ConnectionStream::get_local_ip_and_port(std::string& ip, int& port) const {
  name_by(::getsockname, socket_, ip, port);
}

// The library asks only to refuse what select() could not hold. We poll, and take any number.
socket_t ConnectionStream::socket() const { return 0; }

Readable wait_readable(int first, int second, std::chrono::milliseconds timeout) {
  pollfd wanted[2] = {{first, POLLIN, 0}, {second, POLLIN, 0}};
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    const int ready = ::poll(wanted, 2, static_cast<int>(std::max<long long>(left.count(), 0)));
    if (ready < 0 && errno == EINTR) continue;
    return {ready > 0 && wanted[0].revents != 0, ready > 0 && wanted[1].revents != 0};
  }
}

}  // namespace sightline
