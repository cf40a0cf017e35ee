#include "tests/bench/load_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
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

/// Head and body, by Content-Length; 0 while it is not whole or is no 200.
std::size_t whole_answer(const std::string& text) {
  const std::size_t end = text.find("\r\n\r\n");
  const std::size_t length = text.find("Content-Length: ");
  if (end == std::string::npos || length == std::string::npos ||
      !text.starts_with("HTTP/1.1 200")) {
    return 0;
  }
  const std::size_t size = end + 4 + std::strtoul(text.c_str() + length + 16, nullptr, 10);
  return text.size() >= size ? size : 0;
}

struct Client {
  int socket = -1;
  std::size_t received = 0;  ///< of this answer
  std::string first;         ///< the first answer
  std::size_t size = 0;      ///< of every answer
};

}  // namespace

LoadResult put_load(int port, int connections, const std::string& request, double seconds) {
  LoadResult result;
  std::vector<Client> clients(static_cast<std::size_t>(connections));
  const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
  for (std::size_t i = 0; i < clients.size(); ++i) {
    clients[i].socket = connect_to(port);
    epoll_event wanted{};
    wanted.events = EPOLLIN;
    wanted.data.u64 = i;
    ::epoll_ctl(epoll, EPOLL_CTL_ADD, clients[i].socket, &wanted);
  }
  const auto ask = [&](const Client& client) {
    return ::send(client.socket, request.data(), request.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(request.size());
  };
  const double begin = wall_time_seconds();
  for (const Client& client : clients) {
    if (!ask(client)) ++result.failed;
  }
  std::array<epoll_event, 64> events;
  std::array<char, 65536> buffer;
  double now = begin;
  while (now - begin < seconds) {
    const int ready = ::epoll_wait(epoll, events.data(), static_cast<int>(events.size()), 100);
    for (int i = 0; i < ready; ++i) {
      Client& client = clients[events[static_cast<std::size_t>(i)].data.u64];
      const ssize_t got = ::recv(client.socket, buffer.data(), buffer.size(), 0);
      if (got <= 0) {
        ++result.failed;
        ::epoll_ctl(epoll, EPOLL_CTL_DEL, client.socket, nullptr);
        continue;
      }
      client.received += static_cast<std::size_t>(got);
      if (client.size == 0) {
        client.first.append(buffer.data(), static_cast<std::size_t>(got));
        client.size = whole_answer(client.first);
        if (client.size == 0) continue;
      }
      if (client.received < client.size) continue;
      if (client.received > client.size) ++result.failed;
      client.received = 0;
      ++result.answers;
      if (!ask(client)) ++result.failed;
    }
    now = wall_time_seconds();
  }
  result.seconds = now - begin;
  for (const Client& client : clients) ::close(client.socket);
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
  ::bind(socket, reinterpret_cast<const sockaddr*>(&address), size);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(socket);
  return ntohs(address.sin_port);
}

}  // namespace sightline::bench
