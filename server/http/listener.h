#pragma once
/// The socket that a server listens on.

#include <string>

#include "core/base/result.h"

namespace sightline {

struct ListenAddress {
  std::string host;
  int port = 0;
};
/// "127.0.0.1:8080", "[::1]:0", "localhost:80". Errors: LISTEN_ADDRESS_INVALID.
Result<ListenAddress> parse_listen_address(const std::string& text);

struct Listener {
  int descriptor = -1;  ///< non-blocking; the caller closes it
  int port = 0;
};
/// Listens; connections queue up from here on. Port 0 becomes a free one. Errors: LISTEN_FAILED.
Result<Listener> listen_on(const ListenAddress& address);

}  // namespace sightline
