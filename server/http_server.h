#pragma once
/// cpp-httplib's server with its own way of holding connections.

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <set>
#include <string>

#include "core/base/result.h"
#include "server/connection_stream.h"
#include "server/exchange.h"

namespace sightline {

struct HttpOptions {
  std::size_t workers = 32;  ///< requests answered at once; an idle connection holds one too
  std::chrono::milliseconds idle{30'000};  ///< how long a connection may wait between two requests
  ConnectionStream::Timeouts timeouts;
};

struct ListenAddress {
  std::string host;
  int port = 0;
};
/// "127.0.0.1:8080", "[::1]:0", "localhost:80". Errors: LISTEN_ADDRESS_INVALID.
Result<ListenAddress> parse_listen_address(const std::string& text);

/// The seam is the library's virtual process_and_close_socket: it is called on a worker with an
/// accepted socket, and may answer requests from any Stream by process_request. Ours answers one
/// request after the other, stays awake to a stop while it waits, and leaves no byte of a body for
/// the next request.
///
/// A file descriptor for each connection, a worker for each open one.
class HttpServer : private httplib::Server {
 public:
  using Dispatch = std::function<void(Exchange&)>;
  /// Called when a handler has thrown; says nothing to the client.
  using Thrown = std::function<void(const std::string& request_id, const std::string& what)>;

  HttpServer(const HttpOptions& options, Dispatch dispatch, Thrown thrown);
  ~HttpServer() override;

  /// Listens; connections queue up from here on. Returns the port. Errors: LISTEN_FAILED.
  Result<int> bind(const ListenAddress& address);
  /// Serves until stop, and returns when the last connection has ended.
  void serve();
  /// No new connections; idle ones end, requests that have begun are answered. From any thread.
  void stop();
  /// Breaks every connection off.
  void break_connections();
  bool stopping() const { return stopping_; }

 private:
  bool process_and_close_socket(socket_t socket) override;
  /// Answers what comes; returns when the connection is to be closed.
  void answer_requests(int socket, ConnectionStream& stream);
  bool wait_for_request(int socket, const ConnectionStream& stream) const;
  void dispatch(const httplib::Request& request, httplib::Response& response,
                const httplib::ContentReader* body) const;
  void answer_unparsed(const httplib::Request& request, httplib::Response& response) const;

  const HttpOptions options_;
  const Dispatch dispatch_;
  const Thrown thrown_;
  int listener_ = -1;    ///< a second name of the listening socket, which stays valid
  int stop_event_ = -1;  ///< readable from the stop on
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;
  std::set<int> sockets_;  ///< open connections
};

}  // namespace sightline
