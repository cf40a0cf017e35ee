#pragma once
/// Counts and gauges of a server, in the text format that Prometheus reads.

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

/// The method where it is one that HTTP has, else "other": a client may send any word.
std::string_view known_method(std::string_view method);

/// Gauges that other parts count, at the time of the request.
struct ServerNow {
  std::uint64_t connections = 0;  ///< open
  NamedCounts events = {};        ///< of connections, since the start
  std::uint64_t queued = 0;       ///< requests that wait for a worker
  std::uint64_t traffic = 0;      ///< bytes, see MemoryBudget
  std::uint64_t spooled = 0;      ///< bytes of temporary files
  TreeTotals trees = {};
  std::string kernel = {};
};

/// May be used from many threads.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  struct Request {
    std::string_view method;
    std::string_view route;  ///< the pattern, not the path: a client must not make series
    int status = 0;
    std::chrono::duration<double> time{};  ///< zero where nobody measured
    std::uint64_t rays = 0;
    std::uint64_t boxes = 0;
    QueryWork work = {};
  };
  void count(const Request& request);
  /// Counts a part of a request that was counted before and continues.
  void count_part(std::uint64_t rays, const QueryWork& work) const;
  /// A client whose body a worker has waited for in vain.
  void count_slow() const;
  std::uint64_t slow() const;
  /// All of it, and what the store and the server say now.
  std::string text(const SceneStore& store, const ServerNow& now) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
