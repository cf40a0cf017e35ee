#pragma once
/// StoredScene: what a store tells about a scene at one moment.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/scene/scene.h"

namespace sightline {

/// The state of a scene: waiting for a thread, being loaded, can be queried, could not be loaded, or
/// stored in the origin but not loaded here.
enum class SceneState { kQueued, kLoading, kReady, kFailed, kStored };
/// "queued", "loading", "ready", "failed", "stored"
const char* scene_state_name(SceneState state);

/// The state of a scene at one moment. It never changes; each change makes a new object.
struct StoredScene {
  /// A newer content that is queued or being loaded, or the last one that failed.
  struct Update {
    SceneState state = SceneState::kQueued;
    Progress::Reading progress;
    std::optional<Error> failure;
  };

  std::string id;
  SceneState state = SceneState::kQueued;
  /// The number of the content. No other content of the store has it, in this run or another; 0:
  /// there was no content yet.
  std::uint64_t revision = 0;
  std::string sha256;  ///< SHA-256 of the file's bytes, 64 hexadecimal digits
  /// The entity tag. Contents with equal tags are equal: it depends on the bytes of the file and of
  /// its neighbours, the chosen scene, and changes of nodes.
  std::string etag;
  /// index of the chosen scene of the file; empty: the file's default
  std::optional<std::uint32_t> chosen;
  NodeChanges changes;  ///< changes of nodes since the file was loaded
  /// Size of the file.
  std::uint64_t bytes = 0;
  bool persistent = false;             ///< stored in a data folder, so it survives a restart
  std::shared_ptr<const Scene> scene;  ///< set in state kReady
  std::optional<Error> failure;        ///< set in state kFailed
  Progress::Reading progress;          ///< set in state kLoading
  /// Set in state kReady if a newer content is on its way, or failed.
  std::optional<Update> update;

  /// True if a load or an update is queued or running.
  bool is_moving() const {
    return state == SceneState::kQueued || state == SceneState::kLoading ||
           (update && !update->failure);
  }
};
/// A state that readers share; null means that there is no such scene.
using SceneSnapshot = std::shared_ptr<const StoredScene>;

/// Which scene of a file is loaded.
struct SceneChoice {
  std::optional<std::uint32_t> scene;  ///< index of a scene of the file; empty: the file's default
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
