#pragma once
/// An HTTP server: the event loop, the memory of its requests, and one handler.

#include <atomic>
#include <functional>
#include <string>

#include "core/base/result.h"
#include "server/http/event_loop.h"
#include "server/http/exchange.h"
#include "server/http/http_limits.h"
#include "server/http/listener.h"
#include "server/http/request_memory.h"

namespace sightline {

/// Calls the handler for each request that the event loop has received, and writes the answer. Uses
/// a file descriptor for each connection, and a worker for each request that is being answered.
class HttpServer {
 public:
  using Dispatch = std::function<void(Exchange&)>;
  /// Called when a handler has thrown, with the exception's type: its text may be anything, and is
  /// neither answered nor handed on.
  using Thrown = std::function<void(const std::string& request_id, const std::string& type)>;

  HttpServer(const HttpLimits& limits, Dispatch dispatch, Thrown thrown,
             EventLoopCallbacks rules = {});
  ~HttpServer();

  /// Listens; connections queue up from here on. Returns the port. Errors: LISTEN_FAILED.
  Result<int> bind(const ListenAddress& address);
  /// Serves until stop, and returns when the last connection has ended.
  void serve();
  /// No new connections; idle ones end, requests that have begun are answered. From any thread.
  void stop();
  /// Breaks every connection off, and the work for it. From any thread.
  void break_connections();

  /// Takes what of `limits` is Live. From any thread.
  void change(const HttpLimits& limits) { limits_.take_live(limits); }

  const EventLoopCounts& counts() const { return loop_.counts(); }
  /// Requests that wait for a worker. While it serves.
  std::size_t queued() const { return loop_.queued(); }
  /// Bytes of memory that connections and requests hold, see MemoryBudget.
  std::uint64_t memory() const { return memory_.taken(); }
  /// Bytes of temporary files that bodies and answers hold.
  std::uint64_t spooled() const { return spool_.used(); }

 private:
  void answer(Connection& connection);
  /// Calls the handler; an exception becomes a problem.
  void handle(Exchange& exchange) const;

  HttpLimits limits_;
  const Dispatch dispatch_;
  const Thrown thrown_;
  MemoryBudget memory_;
  Spool spool_;
  std::atomic<bool> stopping_{false};
  int listener_ = -1;
  EventLoop loop_;
};

}  // namespace sightline
