#pragma once
/// The query parameters of requests about scenes.

#include <chrono>
#include <optional>

#include "core/store/stored_scene.h"
#include "server/http/exchange.h"

namespace sightline {

inline constexpr std::chrono::seconds kLongestWait{3600};

struct SceneParameters {
  SceneChoice choice;                             ///< scene=N
  std::optional<std::chrono::milliseconds> wait;  ///< wait=SECONDS, 0 to 3600
};

enum class KnownParameters { kWait, kSceneAndWait };

/// False after it has answered 422 QUERY_INVALID: another parameter, one of them twice, or a value
/// that is none.
bool read_parameters(Exchange& exchange, KnownParameters known, SceneParameters& parameters);

}  // namespace sightline
