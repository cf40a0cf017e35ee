#include "server/http/listener.h"

#include <fcntl.h>
#include <httplib.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <system_error>

namespace sightline {
namespace {

constexpr int kBacklog = 1024;

/// The library's server, of which only the resolution of an address and the bind are used.
class Binder : private httplib::Server {
 public:
  Binder() {
    // Without this the library sets SO_REUSEPORT, and two servers share a port in silence.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
  }
  /// The port; negative with errno, or 0 there, where it cannot be had.
  int bind(const ListenAddress& address) {
    errno = 0;
    if (address.port == 0) return bind_to_any_port(address.host);
    return bind_to_port(address.host, address.port) ? address.port : -1;
  }
  int socket() const { return svr_sock_; }
};

}  // namespace

Result<ListenAddress> parse_listen_address(const std::string& text) {
  const Error invalid{ErrorKind::kInvalid, "LISTEN_ADDRESS_INVALID",
                      "'" + text + "' is no address: write ADDR:PORT or [ADDR]:PORT", ""};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return invalid;
  ListenAddress address{text.substr(0, colon), 0};
  const char* begin = text.data() + colon + 1;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(begin, end, address.port);
  if (begin == end || error != std::errc() || last != end || address.port < 0 ||
      address.port > 65535) {
    return invalid;
  }
  if (address.host.starts_with('[')) {
    if (address.host.size() < 3 || address.host.back() != ']') return invalid;
    address.host = address.host.substr(1, address.host.size() - 2);
  } else if (address.host.find(':') != std::string::npos) {
    return invalid;
  }
  if (address.host.empty()) return invalid;
  return address;
}

Result<Listener> listen_on(const ListenAddress& address) {
  Binder binder;
  const int port = binder.bind(address);
  if (port < 0) {
    return Error{ErrorKind::kConflict, "LISTEN_FAILED",
                 "cannot listen on " + address.host + ":" + std::to_string(address.port) + ": " +
                     (errno != 0 ? std::generic_category().message(errno)
                                 : "the address is not this machine's"),
                 ""};
  }
  const int descriptor = binder.socket();
  // The library asks for a queue of 5.
  ::listen(descriptor, kBacklog);
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  return Listener{descriptor, port};
}

}  // namespace sightline
