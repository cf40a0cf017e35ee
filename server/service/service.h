#pragma once
/// The objects that all routes share. serve makes them and passes them on; none is global.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "core/base/deadline.h"
#include "core/base/live.h"
#include "core/base/places.h"
#include "core/run/engine.h"
#include "core/store/scene_store.h"

namespace sightline {

/// Each is a flag, and shown by /version; those that are Live may change while it serves.
struct ServiceLimits {
  Live<std::uint64_t> scene_bytes{std::uint64_t{4} << 30};
  Live<std::uint64_t> query_bytes{std::uint64_t{256} << 20};
  Live<std::size_t> rays{10'000'000};
  Live<std::size_t> hits{10'000'000};                   ///< listed in one answer
  LiveTime request{std::chrono::milliseconds(60'000)};  ///< for tracing
  std::size_t loads = 100;                              ///< under way or waiting
  std::uint64_t uploads = std::uint64_t{1} << 30;       ///< in memory, in total
  // Limits of the process. The shutdown and the tree cache manager read them elsewhere.
  LiveTime drain{std::chrono::milliseconds(30'000)};  ///< a stop waits so long for what has begun
  LiveTime notice{std::chrono::milliseconds(0)};      ///< between /readyz saying 503 and the stop
  std::uint64_t memory_budget = 0;                    ///< bytes of all scenes; 0: no limit
  std::size_t waiters = 16;  ///< requests that wait for a load, each on a worker

  void take_live(const ServiceLimits& other) {
    scene_bytes = other.scene_bytes;
    query_bytes = other.query_bytes;
    rays = other.rays;
    hits = other.hits;
    request = other.request;
    drain = other.drain;
    notice = other.notice;
  }
};

struct Service {
  const Engine& engine;
  SceneStore& store;
  ServiceLimits limits{};
  std::atomic<bool> stopping{false};
  CancelFlag cancelled{};  ///< set when even requests that have begun must end
  Places waiters{limits.waiters};

  /// From now on; a client may wish for less than the limit.
  Deadline deadline(std::optional<std::uint64_t> timeout_ms = {}) const {
    auto time = limits.request.get();
    if (timeout_ms) time = std::min<decltype(time)>(time, std::chrono::milliseconds(*timeout_ms));
    return Deadline::in(time, &cancelled);
  }
};

}  // namespace sightline
