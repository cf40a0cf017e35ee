#pragma once
/// One content on its way to a name, from its first byte to its outcome.

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/store/scene_upload.h"
#include "core/store/stored_scene.h"

namespace sightline {

class SceneStore;

/// What a request to load came to.
struct Put {
  SceneSnapshot scene;
  bool created = false;  ///< there was no content of this name before
};

/// Known to the store that made it, and to those who wait for it.
class SceneLoad {
 public:
  /// number  loads that begin later have a larger one
  /// alive   counts the loads that there are
  SceneLoad(std::string id, const SceneChoice& choice, std::uint64_t number,
            std::atomic<std::size_t>& alive)
      : id_(std::move(id)), choice_(choice), number_(number), alive_(alive) {
    ++alive_;
  }
  SceneLoad(const SceneLoad&) = delete;
  SceneLoad& operator=(const SceneLoad&) = delete;
  ~SceneLoad() { --alive_; }

  const std::string& id() const { return id_; }
  Progress& progress() { return progress_; }

 private:
  friend class SceneStore;
  friend class IncomingScene;

  const std::string id_;
  const SceneChoice choice_;
  const std::uint64_t number_;
  std::atomic<std::size_t>& alive_;
  Progress progress_;
  /// Belongs to who receives, then to the thread that loads; between them to the store.
  std::optional<SceneUpload> upload_;

  // Under the store's mutex.
  SceneState state_ = SceneState::kQueued;
  bool busy_ = false;    ///< somebody works on it
  bool awaited_ = true;  ///< who asked for it will be told how it ended
  std::optional<Result<Put>> outcome_;
};

/// The bytes of a load while they arrive. Let go without SceneStore::submit, nothing has happened.
class IncomingScene {
 public:
  IncomingScene(SceneStore& store, std::shared_ptr<SceneLoad> load)
      : store_(&store), load_(std::move(load)) {}
  IncomingScene(IncomingScene&&) noexcept = default;
  IncomingScene& operator=(IncomingScene&&) = delete;
  ~IncomingScene();

  /// How many bytes will come; 0: nobody knows.
  void expect(std::uint64_t total) { load_->progress_.begin("receiving", total); }
  /// Errors: LOAD_CANCELLED (the scene was removed meanwhile), STORE_FULL, STORE_IO, MEMORY_FULL;
  /// then only letting go is left.
  Status append(std::span<const std::byte> piece);
  std::uint64_t size() const { return load_->upload_->size(); }

 private:
  friend class SceneStore;
  SceneStore* store_;
  std::shared_ptr<SceneLoad> load_;  ///< null once submitted
};

/// Equal only where the content is, as far as the file and the choice decide it.
std::string tag_of(const std::string& sha256, const SceneChoice& choice);

/// LOAD_CANCELLED: the answer to who waits for a load that was removed.
Error load_cancelled();

}  // namespace sightline
