#pragma once
/// Service: the objects that all routes share. serve makes them and passes them on; none is global.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "core/base/deadline.h"
#include "core/base/live.h"
#include "core/base/semaphore.h"
#include "core/run/engine.h"
#include "core/store/scene_store.h"
#include "core/store/tree_folder.h"

namespace sightline {

/// Each limit is a flag, and /version shows it. Those that are Live may change while the server
/// runs.
struct ServiceLimits {
  /// Size of an uploaded scene, and of the body of a query.
  Live<std::uint64_t> scene_bytes{std::uint64_t{4} << 30};
  Live<std::uint64_t> query_bytes{std::uint64_t{256} << 20};
  Live<std::size_t> rays{10'000'000};
  Live<std::size_t> hits{10'000'000};                   ///< hits that are listed in one answer
  LiveTime request{std::chrono::milliseconds(60'000)};  ///< longest time of an answer
  std::size_t loads = 100;                              ///< loads that run or wait
  std::uint64_t uploads = std::uint64_t{1} << 30;       ///< bytes of all uploads in memory
  // Limits of the whole process, which the shutdown and the tree cache manager use.
  /// how long a shutdown waits for running requests
  LiveTime drain{std::chrono::milliseconds(30'000)};
  /// time between the 503 of /readyz and the shutdown
  LiveTime notice{std::chrono::milliseconds(0)};
  std::uint64_t memory_budget = 0;                      ///< bytes of all scenes; 0: no limit
  std::uint64_t disk_budget = TreeFolder::kUsualBytes;  ///< bytes of stored trees
  std::size_t waiters = 16;  ///< requests that wait for a load, each on a worker

  /// Takes the values that are Live.
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

/// The engine, the store, the limits and the state of a server. One for each server; handlers use
/// it on several threads at once. `engine` and `store` must outlive it.
struct Service {
  const Engine& engine;
  SceneStore& store;
  ServiceLimits limits{};
  /// Set when the server begins to shut down.
  std::atomic<bool> stopping{false};
  CancelFlag cancelled{};  ///< set when running requests must end, too
  /// Permits to wait for a load or for an origin. Functions that only read the service wait, too.
  mutable Semaphore waiters{limits.waiters};

  /// The deadline of an answer that begins now: limits.request, or timeout_ms if that is less. It
  /// refers to `cancelled`.
  Deadline deadline(std::optional<std::uint64_t> timeout_ms = {}) const {
    auto time = limits.request.get();
    if (timeout_ms) time = std::min<decltype(time)>(time, std::chrono::milliseconds(*timeout_ms));
    return Deadline::in(time, &cancelled);
  }
};

}  // namespace sightline

// Tests: tests/integration/settings_test.py
