#pragma once
/// SceneLoad: the load of one content of a scene, from the first byte to the outcome.

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

/// The outcome of a successful load.
struct Put {
  /// The loaded content, even if a later load has replaced it already.
  SceneSnapshot scene;
  bool created = false;  ///< the scene had no content before
};

/// One load, from SceneStore::begin to its outcome. Shared by the store that made it and the
/// threads that wait for it.
class SceneLoad {
 public:
  /// number  later loads have larger numbers
  /// alive   counter of existing loads; shared, because a waiting thread may drop a load after the
  ///         store is destroyed
  SceneLoad(std::string id, const SceneChoice& choice, std::uint64_t number,
            std::shared_ptr<std::atomic<std::size_t>> alive)
      : id_(std::move(id)), choice_(choice), number_(number), alive_(std::move(alive)) {
    ++*alive_;
  }
  SceneLoad(const SceneLoad&) = delete;
  SceneLoad& operator=(const SceneLoad&) = delete;
  ~SceneLoad() { --*alive_; }

  /// The name of the scene.
  const std::string& id() const { return id_; }
  /// The progress of the load; thread-safe.
  Progress& progress() { return progress_; }

 private:
  friend class SceneStore;
  friend class IncomingScene;

  /// Frees the received bytes when they are no longer needed.
  void let_go() {
    upload_.reset();
    neighbours_.reset();
  }

  const std::string id_;
  const SceneChoice choice_;
  const std::uint64_t number_;
  const std::shared_ptr<std::atomic<std::size_t>> alive_;
  Progress progress_;
  std::string demanded_sha256_;  ///< empty: not demanded
  Precondition precondition_;
  /// Owned by the receiving thread, then by the store, then by the loading thread.
  std::optional<SceneUpload> upload_;
  std::optional<CopiedNeighbours> neighbours_;  ///< empty: the file must be self-contained
  /// hash_in_pieces of the bytes if a data folder stores them
  std::optional<std::uint64_t> fingerprint_;

  // Protected by the store's mutex.
  SceneState state_ = SceneState::kQueued;
  /// The revision of this content; set in advance by a later load that replaces it first.
  std::optional<std::uint64_t> revision_;
  /// The number of the content in the origin that is loaded; 0: the load does not come from there.
  std::uint64_t generation_ = 0;
  bool busy_ = false;    ///< a thread works on the load
  bool awaited_ = true;  ///< a client waits for the outcome
  std::optional<Result<Put>> outcome_;
  /// The state to show if there is no memory to record a failure. Null if the scene continues to
  /// show its previous content.
  std::shared_ptr<const StoredScene> failed_;
};

/// The bytes of a load while they are received: append() them, then pass the object to
/// SceneStore::submit. Destroying it without submit abandons the load without any effect. The store
/// must outlive it. Not thread-safe.
class IncomingScene {
 public:
  /// For SceneStore::begin.
  IncomingScene(SceneStore& store, std::shared_ptr<SceneLoad> load)
      : store_(&store), load_(std::move(load)) {}
  IncomingScene(IncomingScene&&) noexcept = default;
  IncomingScene& operator=(IncomingScene&&) = delete;
  ~IncomingScene();

  /// Sets the number of bytes that will arrive, for progress; 0: unknown.
  void expect(std::uint64_t total) { load_->progress_.begin("receiving", total); }
  /// Appends received bytes. Errors: LOAD_CANCELLED (the scene was removed meanwhile), MEMORY_BUSY
  /// (without a data folder), those of io_error; after an error the object can only be destroyed.
  Status append(std::span<const std::byte> piece);
  /// Bytes received so far.
  std::uint64_t size() const { return load_->upload_->size(); }
  /// True if the scene was removed, or the store ends: receiving may stop.
  bool cancelled() const { return load_->progress_.cancelled(); }
  /// Sets the source of files that the scene's file refers to; it is called on the loading thread.
  /// Without one the file must be self-contained.
  void find_neighbours(NeighbourSource source);
  /// Demands that the bytes have this SHA-256. If not, the load fails with SOURCE_HASH_MISMATCH
  /// before anything is loaded.
  void demand_sha256(std::string sha256) { load_->demanded_sha256_ = std::move(sha256); }
  /// Demands that the content that the load would replace satisfies `precondition`. If not, the
  /// load fails with PRECONDITION_FAILED at its end.
  void demand(Precondition precondition) { load_->precondition_ = std::move(precondition); }

 private:
  friend class SceneStore;
  SceneStore* store_;
  std::shared_ptr<SceneLoad> load_;  ///< null after submit
};

/// The entity tag of a content that is determined by the file's bytes and the chosen scene.
/// Different contents have different tags.
std::string tag_of(const std::string& sha256, const SceneChoice& choice);
/// Adds the tag of neighbouring files to a tag; `neighbours` is empty if there are none.
std::string with_neighbours(const std::string& tag, const std::string& neighbours);

/// The entity tag of the content that a record names, without its node changes.
std::string unchanged_tag_of(const SceneRecord& record);
/// What is known of the content that a record names before it is loaded.
StoredScene stored_scene_of(const SceneRecord& record);

/// The error LOAD_CANCELLED for clients that wait for a load of a removed scene.
Error load_cancelled();

}  // namespace sightline
