#pragma once
/// Opens the socket on which a server listens.

#include <string>

#include "core/base/result.h"

namespace sightline {

/// Where to listen.
struct ListenAddress {
  std::string host;  ///< name or address, without brackets
  int port = 0;      ///< 0: any free port
};
/// Parses "127.0.0.1:8080", "[::1]:0" or "localhost:80". Errors: LISTEN_ADDRESS_INVALID.
Result<ListenAddress> parse_listen_address(const std::string& text);

/// A listening socket.
struct Listener {
  int descriptor = -1;  ///< non-blocking; the caller must close it
  int port = 0;
};
/// Starts listening; connections queue up from now on. For port 0 the system chooses a free port.
/// Errors: LISTEN_FAILED.
Result<Listener> listen_on(const ListenAddress& address);

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
