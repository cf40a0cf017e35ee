#pragma once
/// Reads the query parameters of requests about scenes.

#include <chrono>
#include <optional>

#include "core/store/stored_scene.h"
#include "server/http/exchange.h"

namespace sightline {

/// The most that `wait` may be.
inline constexpr std::chrono::seconds kLongestWait{3600};

/// The parameters of a request, with what was given.
struct SceneParameters {
  SceneChoice choice;                             ///< scene=N
  std::optional<std::chrono::milliseconds> wait;  ///< wait=SECONDS, 0 to 3600
};

/// Which parameters are accepted.
enum class KnownParameters { kWait, kSceneAndWait };

/// Reads the parameters; sets only those that were given. Returns false after it has answered 422
/// QUERY_INVALID: an unknown parameter, one given twice, or an invalid value.
bool read_parameters(Exchange& exchange, KnownParameters known, SceneParameters& parameters);

}  // namespace sightline

// Tests: tests/integration/loads_test.py
