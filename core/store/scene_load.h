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
#include "core/store/precondition.h"
#include "core/store/scene_neighbours.h"
#include "core/store/scene_upload.h"
#include "core/store/stored_scene.h"

namespace sightline {

class SceneStore;

/// What a request to load came to.
struct Put {
  /// The content that the request brought, also where a later request has replaced it already.
  SceneSnapshot scene;
  bool created = false;  ///< there was no content of this name before
};

/// One load of a scene. Shared by the store that made it and the threads that wait for it.
class SceneLoad {
 public:
  /// number  loads that begin later have a larger one
  /// alive   counts the existing loads; shared, because a waiting thread may drop a load after the
  ///         store is gone
  SceneLoad(std::string id, const SceneChoice& choice, std::uint64_t number,
            std::shared_ptr<std::atomic<std::size_t>> alive)
      : id_(std::move(id)), choice_(choice), number_(number), alive_(std::move(alive)) {
    ++*alive_;
  }
  SceneLoad(const SceneLoad&) = delete;
  SceneLoad& operator=(const SceneLoad&) = delete;
  ~SceneLoad() { --*alive_; }

  const std::string& id() const { return id_; }
  Progress& progress() { return progress_; }

 private:
  friend class SceneStore;
  friend class IncomingScene;

  /// Of what came, once nobody needs it any more.
  void let_go() {
    upload_.reset();
    neighbours_.reset();
  }

  const std::string id_;
  const SceneChoice choice_;
  const std::uint64_t number_;
  const std::shared_ptr<std::atomic<std::size_t>> alive_;
  Progress progress_;
  std::string demanded_sha256_;  ///< empty: any will do
  Precondition precondition_;
  /// The receiving thread owns these first, then the thread that loads; in between the store.
  std::optional<SceneUpload> upload_;
  std::optional<CopiedNeighbours> neighbours_;  ///< empty: the file has to be whole
  std::optional<std::uint64_t> fingerprint_;    ///< of the bytes, where a data folder stores them

  // Under the store's mutex.
  SceneState state_ = SceneState::kQueued;
  /// The revision of this content if a later load replaces it first; set by that load.
  std::optional<std::uint64_t> revision_;
  bool busy_ = false;    ///< somebody works on it
  bool awaited_ = true;  ///< a waiting client will be told how it ended
  std::optional<Result<Put>> outcome_;
  /// What the name shows if there is not even memory to say that the load has failed; null where it
  /// shows the content that it had before.
  std::shared_ptr<const StoredScene> failed_;
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
  /// Errors: LOAD_CANCELLED (the scene was removed meanwhile), those of io_error; then only letting
  /// go is left.
  Status append(std::span<const std::byte> piece);
  std::uint64_t size() const { return load_->upload_->size(); }
  bool cancelled() const { return load_->progress_.cancelled(); }
  /// Where the file's neighbours come from, while it is loaded; `source` is called on the thread
  /// that loads.
  void find_neighbours(NeighbourSource source);
  /// SOURCE_HASH_MISMATCH at the end, before anything is loaded, unless the bytes have this
  /// SHA-256.
  void demand_sha256(std::string sha256) { load_->demanded_sha256_ = std::move(sha256); }
  /// PRECONDITION_FAILED at the end, unless the content that would be replaced then is one of
  /// these.
  void demand(Precondition precondition) { load_->precondition_ = std::move(precondition); }

 private:
  friend class SceneStore;
  SceneStore* store_;
  std::shared_ptr<SceneLoad> load_;  ///< null once submitted
};

/// Equal only where the content is, as far as the file and the choice decide it.
std::string tag_of(const std::string& sha256, const SceneChoice& choice);
/// Adds the tag of the neighbouring files, which is empty where there are none.
std::string with_neighbours(const std::string& tag, const std::string& neighbours);

/// That of the content that a record names, without its changes.
std::string unchanged_tag_of(const SceneRecord& record);

/// LOAD_CANCELLED: the error for clients that wait for a removed load.
Error load_cancelled();

}  // namespace sightline
