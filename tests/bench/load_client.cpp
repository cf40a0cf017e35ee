#include "tests/bench/load_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "tests/bench/machine.h"

namespace sightline::bench {
namespace {

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = local(port);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    ::close(socket);
    return -1;
  }
  const int yes = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  return socket;
}

constexpr std::string_view kHeadEnd = "\r\n\r\n", kLength = "Content-Length: ";
/// Ends an answer in chunks; the answers that are measured have lines that end otherwise.
constexpr std::string_view kLastChunk = "\r\n0\r\n\r\n";

/// One connection with one request under way.
class Client {
 public:
  Client(int port, const std::string& request)
      : port_(port), request_(request), socket_(connect_to(port)) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { ::close(socket_); }

  int socket() const { return socket_; }
  /// The next request, on a new connection where the last answer has ended the old one.
  void begin() {
    sent_ = 0;
    if (!closes_) return;
    ::close(socket_);
    socket_ = connect_to(port_);
  }
  bool closes() const { return closes_; }
  bool has_more() const { return sent_ < request_.size(); }
  bool send() {
    const ssize_t some = ::send(socket_, request_.data() + sent_, request_.size() - sent_,
                                MSG_NOSIGNAL | MSG_DONTWAIT);
    if (some > 0) sent_ += static_cast<std::size_t>(some);
    return some > 0 || errno == EAGAIN;
  }

  enum class Got { kPart, kAnswer, kFault };
  /// Reads what has come.
  Got receive(std::string& buffer) {
    const ssize_t some = ::recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (some < 0 && errno == EAGAIN) return Got::kPart;
    if (some <= 0) return Got::kFault;
    const std::string_view piece(buffer.data(), static_cast<std::size_t>(some));
    received_ += piece.size();
    if (head_.find(kHeadEnd) == std::string::npos) {
      head_.append(piece);
      const std::size_t end = head_.find(kHeadEnd);
      if (end == std::string::npos) return Got::kPart;
      if (!head_.starts_with("HTTP/1.1 200")) return Got::kFault;
      closes_ = head_.substr(0, end).find("\r\nConnection: close") != std::string::npos;
      const std::size_t length = head_.substr(0, end).find(kLength);
      size_ = length == std::string::npos
                  ? 0
                  : end + kHeadEnd.size() +
                        std::strtoul(head_.c_str() + length + kLength.size(), nullptr, 10);
    }
    last_.append(piece.substr(piece.size() - std::min(piece.size(), kLastChunk.size())));
    last_.erase(0, last_.size() - std::min(last_.size(), kLastChunk.size()));
    if (size_ > 0 ? received_ < size_ : last_ != kLastChunk) return Got::kPart;
    const bool good = size_ == 0 || received_ == size_;
    received_ = 0;
    head_.clear();
    last_.clear();
    return good ? Got::kAnswer : Got::kFault;
  }

 private:
  const int port_;
  const std::string& request_;
  int socket_;
  bool closes_ = false;
  std::size_t sent_ = 0, received_ = 0;
  std::size_t size_ = 0;  ///< of this answer; 0: it comes in chunks
  std::string head_, last_;
};

}  // namespace

LoadResult put_load(int port, int connections, const std::string& request, double seconds) {
  LoadResult result;
  std::vector<std::unique_ptr<Client>> clients;
  const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
  const auto watch = [&](std::size_t i, int how) {
    epoll_event wanted{};
    wanted.events = clients[i]->has_more() ? EPOLLIN | EPOLLOUT : EPOLLIN;
    wanted.data.u64 = i;
    ::epoll_ctl(epoll, how, clients[i]->socket(), &wanted);
  };
  // A server with few places for who is not accepted yet lets a client try again after a second.
  for (int i = 0; i < connections; ++i) clients.push_back(std::make_unique<Client>(port, request));
  const double begin = wall_time_seconds();
  for (std::size_t i = 0; i < clients.size(); ++i) {
    clients[i]->send();
    watch(i, EPOLL_CTL_ADD);
  }
  std::array<epoll_event, 64> events;
  std::string buffer(std::size_t{1} << 20, '\0');
  std::size_t open = clients.size();
  double now = begin;
  while (open > 0) {
    const int ready = ::epoll_wait(epoll, events.data(), static_cast<int>(events.size()), 100);
    for (int k = 0; k < ready; ++k) {
      const std::size_t i = events[static_cast<std::size_t>(k)].data.u64;
      Client& client = *clients[i];
      const bool had_more = client.has_more();
      const bool good = !had_more || client.send();
      const auto got = good ? client.receive(buffer) : Client::Got::kFault;
      bool done = !good || got == Client::Got::kFault;
      if (done) ++result.failed;
      if (got == Client::Got::kAnswer) {
        ++result.answers;
        // Whatever was begun is answered, so that all the work was for what is counted.
        done = now - begin >= seconds;
        if (!done) {
          if (client.closes()) ::epoll_ctl(epoll, EPOLL_CTL_DEL, client.socket(), nullptr);
          client.begin();
          if (!client.send()) {
            ++result.failed;
            done = true;
          } else if (client.closes()) {
            watch(i, EPOLL_CTL_ADD);
          }
        }
      }
      if (done) {
        // Its socket is closed: a server may have a worker that waits for nothing else.
        clients[i].reset();
        --open;
      } else if (client.has_more() != had_more) {
        watch(i, EPOLL_CTL_MOD);
      }
    }
    now = wall_time_seconds();
  }
  result.seconds = now - begin;
  ::close(epoll);
  return result;
}

bool is_listening(int port) {
  const int socket = connect_to(port);
  if (socket >= 0) ::close(socket);
  return socket >= 0;
}

int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = local(0);
  socklen_t size = sizeof address;
  const bool found = ::bind(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                     ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(socket);
  return found ? ntohs(address.sin_port) : 0;
}

}  // namespace sightline::bench
