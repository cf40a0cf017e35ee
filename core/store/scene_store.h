#pragma once
/// Named scenes, each an immutable revision that readers share; persistent where there is a data
/// folder.

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "core/scene/scene.h"
#include "core/store/revision_counter.h"
#include "core/store/scene_folder.h"
#include "core/store/scene_upload.h"

namespace sightline {

enum class SceneState { kQueued, kLoading, kReady, kFailed };
/// "queued", "loading", "ready", "failed"
const char* scene_state_name(SceneState state);

/// What is known of a scene at one moment. Never changes: a later moment is another object.
struct StoredScene {
  std::string id;
  SceneState state = SceneState::kQueued;
  /// No two contents of a store have the same number, in no run of it; 0 before the first content.
  std::uint64_t revision = 0;
  std::string sha256;  ///< of the file's bytes, 64 hexadecimal digits
  /// Equal only where the content is: the hash, and what else the content depends on (the scene
  /// that was chosen, the bytes of other files).
  std::string etag;
  std::optional<std::uint32_t> chosen;  ///< of the file's scenes; empty: the file's choice
  std::uint64_t bytes = 0;
  bool persistent = false;             ///< survives a restart
  std::shared_ptr<const Scene> scene;  ///< when ready
  std::optional<Error> failure;        ///< when failed
};
using SceneSnapshot = std::shared_ptr<const StoredScene>;

struct SceneChoice {
  std::optional<std::uint32_t> scene;  ///< of the file's scenes; empty: the file's choice
};

/// Turns the bytes of a file into a scene. Handed in, because this room knows no file format. May
/// be called from several threads at once; the bytes are gone when it returns.
using SceneLoader = std::function<Result<std::shared_ptr<const Scene>>(
    std::span<const std::byte> bytes, const SceneChoice& choice)>;

/// A scene that does not come by upload: made or read by `load` on a thread of the store.
struct PreloadedScene {
  std::shared_ptr<const Scene> scene;
  std::string sha256;      ///< of the file
  std::string neighbours;  ///< a hash of what came from other files; empty where nothing did
  std::uint64_t bytes = 0;
};
struct Preload {
  std::string id;
  std::function<Result<PreloadedScene>()> load;
};

struct StoreOptions {
  std::filesystem::path folder;  ///< empty: scenes live in memory only
  int loads_at_once = 2;         ///< building needs several times the memory of the built scene
  /// Told of each scene of the start that fails, once; from threads of the store.
  std::function<void(const std::string& id, const Error& error)> report = {};
};

/// May be used from many threads.
class SceneStore {
 public:
  /// Reads the catalogue and starts to load it, then the preloads, in the background: what is
  /// damaged fails by itself and stops nothing. A scene of the catalogue goes before a preload of
  /// the same name. Errors: those of SceneFolder::open, SCENE_ID_INVALID of a preload.
  static Result<std::unique_ptr<SceneStore>> open(const StoreOptions& options, SceneLoader loader,
                                                  std::vector<Preload> preloads);
  /// Waits for the load that is running; the rest of the queue is left.
  ~SceneStore();

  /// Null when there is no scene of this name.
  SceneSnapshot find(const std::string& id) const;
  /// Sorted by id.
  std::vector<SceneSnapshot> list() const;
  /// Whether everything that was there at the start is ready or failed.
  bool settled() const;

  /// Errors: STORE_FULL, STORE_IO.
  Result<SceneUpload> begin_upload();

  struct Put {
    SceneSnapshot scene;
    bool created = false;  ///< there was no content of this name before
  };
  /// Loads the upload and makes it the content of `id`: readers see the old revision until the new
  /// one is ready and durable. Returns when that is so. The last of several puts at once stands.
  /// Errors: SCENE_ID_INVALID, those of the loader, STORE_FULL, STORE_IO; then nothing has changed.
  Result<Put> put(const std::string& id, SceneUpload upload, const SceneChoice& choice);
  /// Errors: SCENE_NOT_FOUND, SCENE_LOADING (its first content is still on its way), STORE_IO.
  Status remove(const std::string& id);

 private:
  /// A name's time from its first mention to its removal has one ticket: work that was begun for
  /// an earlier time of the same name finds another ticket and changes nothing.
  struct Entry {
    SceneSnapshot snapshot;
    std::uint64_t ticket = 0;
  };
  class LoadSlot;

  SceneStore(const StoreOptions& options, SceneLoader loader);
  void load_in_background(std::vector<std::function<void()>> jobs);
  void load_record(const SceneRecord& record, std::uint64_t ticket);
  void load_preload(const Preload& preload, std::uint64_t ticket);
  Result<std::shared_ptr<const Scene>> load(std::span<const std::byte> bytes,
                                            const SceneChoice& choice) const;
  Result<std::shared_ptr<const Scene>> load_upload(const std::string& id, std::uint64_t ticket,
                                                   SceneUpload& upload, const SceneChoice& choice);
  /// Makes an entry of this name, unless there is one; returns its ticket, or 0.
  std::uint64_t add(StoredScene scene);
  /// Changes the snapshot of a scene that has no content yet. False, and nothing happens, when its
  /// time is over or it got content from elsewhere.
  bool advance(const std::string& id, std::uint64_t ticket,
               const std::function<void(StoredScene&)>& change);
  void fail(const std::string& id, std::uint64_t ticket, const Error& error);
  /// Removes a name that never got content.
  void give_up(const std::string& id, std::uint64_t ticket);

  const StoreOptions options_;
  const SceneLoader loader_;
  std::unique_ptr<SceneFolder> folder_;

  mutable std::mutex mutex_;  ///< for what follows; never held while a file is touched
  std::map<std::string, Entry, std::less<>> entries_;
  std::uint64_t next_ticket_ = 1;
  std::size_t jobs_left_ = 0;
  int loads_ = 0;
  bool stopping_ = false;
  std::condition_variable slot_free_;

  std::mutex commit_mutex_;    ///< disk and memory see puts and removals in the same order
  RevisionCounter revisions_;  ///< under commit_mutex_
  std::vector<std::thread> threads_;
};

}  // namespace sightline
