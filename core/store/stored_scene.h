#pragma once
/// What a store tells about a scene.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/scene/scene.h"

namespace sightline {

enum class SceneState { kQueued, kLoading, kReady, kFailed };
/// "queued", "loading", "ready", "failed"
const char* scene_state_name(SceneState state);

/// What is known of a scene at one moment. Never changes: a later moment is another object.
struct StoredScene {
  /// A content on its way, or the last one that failed on it.
  struct Update {
    SceneState state = SceneState::kQueued;
    Progress::Reading progress;
    std::optional<Error> failure;
  };

  std::string id;
  SceneState state = SceneState::kQueued;
  /// No two contents of a store have the same number, in no run of it; 0 before the first content.
  std::uint64_t revision = 0;
  std::string sha256;  ///< of the file's bytes, 64 hexadecimal digits
  /// Equal only where the content is: the hash, and what else the content depends on (the scene
  /// that was chosen, the bytes of other files, changes of nodes).
  std::string etag;
  std::optional<std::uint32_t> chosen;  ///< of the file's scenes; empty: the file's choice
  NodeChanges changes;                  ///< since the file came
  std::uint64_t bytes = 0;
  bool persistent = false;             ///< survives a restart
  std::shared_ptr<const Scene> scene;  ///< when ready
  std::optional<Error> failure;        ///< when failed
  Progress::Reading progress;          ///< when loading
  /// When ready, and a newer content is on its way or has failed since.
  std::optional<Update> update;

  /// Whether a load or an update is queued or in progress.
  bool is_moving() const {
    return state == SceneState::kQueued || state == SceneState::kLoading ||
           (update && !update->failure);
  }
};
using SceneSnapshot = std::shared_ptr<const StoredScene>;

struct SceneChoice {
  std::optional<std::uint32_t> scene;  ///< of the file's scenes; empty: the file's choice
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
