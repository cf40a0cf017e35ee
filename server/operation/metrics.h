#pragma once
/// Metrics: counters and gauges of a server, in the text format of Prometheus.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/query/query_work.h"
#include "core/scene/tree_stats.h"
#include "server/service/scene_stats.h"

namespace sightline {

class SceneStore;

/// The method if it is a standard one of HTTP, else "other", because a client may send any word.
std::string_view known_method(std::string_view method);

/// Values at the time of a request for metrics, which other parts of the server count.
struct ServerNow {
  std::uint64_t connections = 0;   ///< open connections
  NamedCounts events = {};         ///< counts of events of connections since the start
  std::uint64_t queued = 0;        ///< requests that wait for a worker
  std::uint64_t traffic = 0;       ///< bytes of memory: MemoryBudget
  std::uint64_t spooled = 0;       ///< bytes of temporary files
  std::uint64_t send_buffers = 0;  ///< bytes of answers in send buffers of the kernel
  TreeTotals trees = {};
  std::string kernel = {};
};

/// Counts requests and writes the text of /metrics. Thread-safe.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  /// A request to count.
  struct Request {
    std::string_view method;
    /// the pattern of the route, not the path, so that clients cannot create time series
    std::string_view route;
    int status = 0;
    std::chrono::duration<double> time{};  ///< zero: not measured
    std::uint64_t rays = 0;
    std::uint64_t boxes = 0;
    QueryWork work = {};
  };
  /// Counts one request with its work.
  void count(const Request& request);
  /// Counts a part of a stream, whose request was counted before.
  void count_part(std::uint64_t rays, const QueryWork& work) const;
  /// Counts a client that sent its body too slowly.
  void count_slow() const;
  /// The count of count_slow.
  std::uint64_t slow() const;
  /// Returns all metrics, with present values of the store and the server.
  std::string text(const SceneStore& store, const ServerNow& now) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
