#pragma once
/// What a server has done and holds, in the text format that Prometheus reads.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/query/query_work.h"
#include "server/scene_stats.h"

namespace sightline {

class SceneStore;

/// The method where it is one that HTTP has, else "other": a client may send any word.
std::string_view known_method(std::string_view method);

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
  /// Of a request that is counted already, and goes on.
  void count_part(std::uint64_t rays, const QueryWork& work) const;
  /// All of it, and what the store and the door say now.
  std::string text(const SceneStore& store, const NamedCounts& door, std::size_t queued,
                   std::uint64_t traffic) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sightline
