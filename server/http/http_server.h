#pragma once
/// HttpServer: an event loop, the memory of its requests, and a handler.

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

/// Calls the handler for each request that the event loop has received, and writes the answer.
/// Construct, bind(), then serve() on one thread; stop() on another thread ends serve(). Uses a
/// file descriptor for each connection, and a worker for each request that is being answered.
class HttpServer {
 public:
  /// The handler. It is called on several threads at once. An exception of it is answered with 507
  /// MEMORY_FULL for std::bad_alloc, else with 500 INTERNAL.
  using Dispatch = std::function<void(Exchange&)>;
  /// Called on a worker if a handler throws, with the type of the exception. The text of the
  /// exception is not passed on and not answered, because it may contain anything.
  using Thrown = std::function<void(const std::string& request_id, const std::string& type)>;

  /// Copies `limits`. `dispatch`, `thrown` and `rules` may be called until serve() has returned.
  HttpServer(const HttpLimits& limits, Dispatch dispatch, Thrown thrown,
             EventLoopCallbacks rules = {});
  /// Closes the listening socket. Precondition: serve() has returned, or was not called.
  ~HttpServer();

  /// Starts listening and starts the workers; connections queue up from now on. Returns the port.
  /// Errors, after which serve() must not be called: LISTEN_FAILED, THREADS_FEW.
  Result<int> bind(const ListenAddress& address);
  /// Serves until stop(), and returns when the last connection has ended. Called once, after
  /// bind().
  void serve();
  /// Stops accepting; idle connections are closed, requests that have begun are answered.
  /// Thread-safe.
  void stop();
  /// Stops, closes every connection and cancels its work, within 100 ms. Thread-safe.
  void break_connections();

  /// Takes the Live members of `limits`. Thread-safe.
  void change(const HttpLimits& limits) { limits_.take_live(limits); }

  const EventLoopCounts& counts() const { return loop_.counts(); }
  /// Requests that wait for a worker. Thread-safe, from bind() until serve() returns.
  std::size_t queued() const { return loop_.queued(); }
  /// What admits requests; lives as long as this object.
  MemoryBudget& budget() { return memory_; }
  /// Bytes of memory that connections and requests use (MemoryBudget).
  std::uint64_t memory() const { return memory_.taken(); }
  /// Bytes of temporary files of bodies and answers.
  std::uint64_t spooled() const { return spool_.used(); }

 private:
  void answer(Connection& connection);
  /// Calls the handler; turns an exception into a problem.
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
