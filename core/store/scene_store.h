#pragma once
/// SceneStore: named scenes. Each content is an immutable revision that readers share. Contents are
/// persistent if there is a data folder, and are loaded in the background, a few at a time.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/scene/scene.h"
#include "core/store/origin_scenes.h"
#include "core/store/revision_counter.h"
#include "core/store/scene_folder.h"
#include "core/store/scene_load.h"
#include "core/store/stored_scene.h"
#include "core/store/work_queue.h"

namespace sightline {

/// The input of a SceneLoader.
struct LoadInput {
  /// the file; freed when the loader returns, unless there is an `owner`
  std::span<const std::byte> bytes;
  SceneChoice choice;
  Progress& progress;       ///< the loader reports its stages, and may end early if it is cancelled
  std::string sha256 = {};  ///< hash of the bytes; empty if no data folder stores them
  /// Returns the bytes of a neighbour of the file; freed like `bytes`. Empty if the file must be
  /// self-contained.
  std::function<Result<std::span<const std::byte>>(const std::string& name)> neighbour = {};
  /// Owner of the bytes; they do not change while it is held, because only the store writes to the
  /// data folder. Null: the bytes are valid only during the call.
  std::shared_ptr<const void> owner = {};
  std::span<const NodeChange> changes = {};  ///< changes of nodes that the loader must apply
  /// The loader calls it with each part of the bytes that the scene refers to; with an `owner`, the
  /// store frees all other parts. It may be called from several threads. Empty: must not be called.
  std::function<void(std::span<const std::byte>)> claim = {};
};
/// Makes a scene from the bytes of a file. A parameter of the store, because this room knows no
/// file format. It may be called from several threads at once.
using SceneLoader = std::function<Result<std::shared_ptr<const Scene>>(const LoadInput& input)>;

/// Fetches the bytes of a scene and appends them to `incoming`, on a thread of the store. It must
/// not throw.
using SceneFetch = std::function<Status(IncomingScene& incoming)>;

/// A scene that is not uploaded but made or read by Preload::load.
struct PreloadedScene {
  std::shared_ptr<const Scene> scene;
  std::string sha256;      ///< of the file
  std::string neighbours;  ///< hash of the other files that it was made from; empty: none
  std::uint64_t bytes = 0;
};
/// A scene to be loaded at start; `load` runs on a thread of the store.
struct Preload {
  std::string id;
  std::function<Result<PreloadedScene>(Progress& progress)> load;
};

/// What a store shares with others. docs/guides/replicas.md describes the whole.
struct SharedScenes {
  std::shared_ptr<OriginScenes> origin = {};  ///< null: the store shares nothing
  /// Names the origin in the data folder, so that the folder is not used with another one.
  std::string name = {};
  /// Time between two checks of what other stores have changed.
  std::chrono::milliseconds refresh{5'000};
  /// Bytes of files in the data folder; beyond it the least recently used scenes leave this store,
  /// but not the origin. 0: no limit.
  std::uint64_t cache_bytes = 0;
  /// Called with a line for the log when the origin begins to fail, and when it works again, from
  /// threads of the store. Not null if there is an origin.
  std::function<void(const std::string& line)> report = {};
};

/// Options of a store.
struct StoreOptions {
  std::filesystem::path folder = {};  ///< data folder; empty: scenes are in memory only
  int loads_at_once = 2;  ///< loading a scene needs several times the memory of the loaded scene
  /// A fetch may wait for a slow source. One from an origin has its files in memory.
  int fetches_at_once = 4;
  std::size_t loads_max = 100;  ///< largest number of requests to load that run or wait
  /// Bytes of all uploads in total if there is no folder; a single upload may be larger.
  std::uint64_t uploads_memory = std::uint64_t{1} << 30;
  /// Called once for each load that fails while no client waits for it, from threads of the store.
  std::function<void(const std::string& id, const Error& error)> report = {};
  /// Called with each scene that is made by changing nodes, before it becomes visible. The change
  /// fails if this returns an error.
  std::function<Status(const std::shared_ptr<const Scene>& scene)> admit = {};
  /// Memory for the files of scenes that exceed the memory budget.
  OverflowFor overflow_for = {};
  /// With an origin, the data folder is a cache of it: changes are made in the origin first, and
  /// what the folder lacks is fetched. The folder must be given.
  SharedScenes shared = {};
};

/// The scenes of a server: open(), then begin(), append the bytes and submit(), or fetch(); find()
/// returns the present content. Functions may throw std::bad_alloc. Thread-safe.
class SceneStore {
 public:
  /// Opens the data folder, and starts to load its scenes and then the preloads, in the background.
  /// A damaged scene fails alone. A scene of the folder takes precedence over a preload of the same
  /// name. Errors: those of SceneFolder::open, SCENE_ID_INVALID of a preload.
  static Result<std::unique_ptr<SceneStore>> open(const StoreOptions& options, SceneLoader loader,
                                                  std::vector<Preload> preloads);
  /// Cancels running loads and waits for the store's threads. Precondition: no thread waits for a
  /// load.
  ~SceneStore();

  /// The present state of a scene; null if there is none.
  SceneSnapshot find(const std::string& id) const;
  /// The content of a scene for a request that accepts revisions from `minimum` on; null if there is
  /// no such scene. Without an origin: as find(). With an origin, a content that this store has is
  /// returned at once. Otherwise the newest content is loaded from the origin, and the call waits
  /// until it is ready, or until the deadline; the state then says that it is still loading. Errors:
  /// REVISION_UNKNOWN (no content has so large a revision), those of the load and of Origin.
  Result<SceneSnapshot> obtain(const std::string& id, std::uint64_t minimum,
                               const Deadline& deadline);
  /// True if the store has an origin.
  bool is_shared() const { return options_.shared.origin != nullptr; }
  /// SharedScenes::cache_bytes
  std::uint64_t cache_bytes() const { return options_.shared.cache_bytes; }
  /// True if obtain() would return at once.
  bool has(const std::string& id, std::uint64_t minimum) const;
  /// All scenes, sorted by id; with an origin also those that are stored only there.
  std::vector<SceneSnapshot> list() const;
  /// True if every scene that was to be loaded at start is ready or has failed.
  bool settled() const;

  /// Begins a load. The scene is shown as loading; its old content stays until the new one is
  /// ready. Errors: SCENE_ID_INVALID, LOADS_TOO_MANY, those of io_error.
  Result<IncomingScene> begin(const std::string& id, const SceneChoice& choice);
  /// Loads the received content in the background and makes it the content of its scene. Readers
  /// see the old revision until the new one is ready and durable. Of several loads at once, the
  /// last to begin wins. Each client gets the result of its own load; revisions are in the order in
  /// which the loads began.
  ///
  /// awaited  true: the caller will call wait(); false: a failure is recorded in the scene's state
  std::shared_ptr<SceneLoad> submit(IncomingScene incoming, bool awaited = true);
  /// Begins a load whose bytes `source` fetches in the background, and submits it. Errors: those of
  /// begin.
  Result<std::shared_ptr<SceneLoad>> fetch(const std::string& id, const SceneChoice& choice,
                                           SceneFetch source, bool awaited);
  /// Waits for the outcome of a load: its content is ready and durable, or an error. Errors:
  /// LOAD_CANCELLED, SOURCE_HASH_MISMATCH, PRECONDITION_FAILED, those of the fetch, of the loader
  /// and of io_error; the content of the scene is then as before. Empty at the deadline; the load
  /// then continues, and find() shows its failure. Must be called once for each load that was
  /// submitted with `awaited`.
  std::optional<Result<Put>> wait(SceneLoad& load, const Deadline& deadline);
  /// Changes nodes of the present content, which makes one new revision; it is durable if the
  /// content is. After an error nothing has changed. A running load continues, and will replace the
  /// changed content. Errors:
  /// SCENE_NOT_FOUND, SCENE_LOADING, SCENE_FAILED, PRECONDITION_FAILED, CHANGES_TOO_MANY, those of
  /// resolve, of Scene::changed, of StoreOptions::admit and of io_error.
  Result<SceneSnapshot> change(const std::string& id, const SceneChange& change,
                               const Precondition& precondition = {});
  /// Removes a scene, also from the data folder, and cancels its running loads. Errors:
  /// SCENE_NOT_FOUND, PRECONDITION_FAILED, those of SceneFolder::remove; the scene is then still
  /// shown. Snapshots that readers hold stay valid. Returns the revision of the removal in the
  /// origin; 0 without an origin.
  Result<std::uint64_t> remove(const std::string& id, const Precondition& precondition = {});

  /// True if a scene could not be stored for lack of space, and no scene has become ready since.
  bool is_full() const { return full_; }
  /// True if the data folder failed (STORE_IO) and was not written successfully since.
  bool is_failing() const { return failing_; }
  /// True if the origin failed at the last check.
  bool is_origin_failing() const { return is_origin_failing_; }

  /// Counts of ended loads by outcome: "ready", "failed", "cancelled".
  std::vector<std::pair<std::string, std::uint64_t>> load_counts() const;

  /// A number that increases with each change of the state of any scene.
  std::uint64_t changes() const;
  /// Waits until changes() differs from `seen`, or until the deadline.
  void wait_for_change(std::uint64_t seen, const Deadline& deadline) const;

 private:
  friend class IncomingScene;
  using LoadPointer = std::shared_ptr<SceneLoad>;
  using LoadCount = std::shared_ptr<std::atomic<std::size_t>>;

  /// A name from its first load to its removal.
  struct Entry {
    SceneSnapshot content;           ///< never null; at first it has only the name
    std::vector<LoadPointer> loads;  ///< running loads, in the order in which they began
    std::uint64_t standing = 0;      ///< number of the load that brought the content
    std::uint64_t used = 0;          ///< larger for scenes that were obtained later
  };

  SceneStore(const StoreOptions& options, SceneLoader loader);
  void start(const SceneFolder::Catalogue& catalogue, std::vector<Preload> preloads);
  /// Null if there is a scene of this name already.
  LoadPointer add_start(StoredScene scene, const SceneChoice& choice);
  /// `bytes` is the size of the file.
  void push_start(const LoadPointer& load, std::uint64_t bytes, std::function<void()> job);
  /// Makes `next` the content of its name if the content is still `before`; returns false if it is
  /// not.
  Result<bool> commit_change(const SceneSnapshot& before, StoredScene& next);
  /// Runs `work`; fails the load if it throws, as it does when memory is exhausted.
  void guarded(const LoadPointer& load, const std::function<void()>& work);
  void load_record(const SceneRecord& record, const LoadPointer& load);
  using LoadedScene = Result<std::shared_ptr<const Scene>>;
  /// Calls the loader with the files of a record. The caller drops what is not claimed.
  LoadedScene run_record(const SceneRecord& record, const RecordFiles& files,
                         SceneLoad& load) const;
  /// Reads all files of the record; after an error `failed` is the file that could not be read.
  Result<RecordFiles> read_files(const SceneRecord& record, SceneFolder::File& failed) const;
  /// Reads all files of the record. If it returns STORE_DAMAGED, the damaged file is in quarantine,
  /// or was deleted from a cache; or the message says why not.
  Result<RecordFiles> check_record(const SceneRecord& record, const LoadPointer& load);
  /// Removes the content of a name whose record the folder no longer has.
  void forget_record(const LoadPointer& load);
  void load_preload(const Preload& preload, const LoadPointer& load);

  // How a store follows its origin: scene_store_origin.cpp.

  /// Checks that the data folder is a cache of this origin, or marks a new folder as one.
  Status check_cache(bool has_scenes) const;
  /// has(), with mutex_ held.
  bool has_now(const std::string& id, std::uint64_t minimum) const;
  /// Asks the origin for the newest content and loads it if this store lacks it. As obtain().
  Result<SceneSnapshot> catch_up(const std::string& id, std::uint64_t minimum,
                                 const Deadline& deadline);
  /// Begins to load a content of the origin, or returns the load that is under way already.
  LoadPointer load_from_origin(const std::string& id, std::uint64_t revision);
  void fetch_from_origin(const LoadPointer& load);
  /// Loads a content of the origin, and stores it in the data folder meanwhile.
  void load_fetched(const SceneRecord& record, const LoadPointer& load);
  /// The files of a content of the origin: from the data folder if they are there undamaged, else
  /// copied.
  Result<FetchedFiles> fetch_files(const SceneRecord& record, const LoadPointer& load);
  /// Copies a file of the origin to memory and to `copy`, and checks its hash.
  Result<FileBytes> copy_file(const std::string& sha256, std::uint64_t bytes, SceneLoad& load,
                              const FileDescriptor& copy);
  /// Stores a content of the origin in the data folder, unless a newer one is there.
  Status store_in_cache(const SceneRecord& record, std::vector<TemporaryFile>& copies,
                        SceneLoad& load);
  LoadedScene run_fetched(const SceneRecord& record, const RecordFiles& files,
                          const LoadPointer& load);
  void end_fetch(const SceneRecord& record, const LoadPointer& load,
                 std::shared_ptr<const Scene> scene);
  /// Stores the files of an upload in the origin.
  Status store_in_origin(SceneLoad& load, const std::string& sha256);
  /// Makes the record the newest content in the origin; sets its revision. Returns true if the
  /// scene had no content before. Errors: PRECONDITION_FAILED, ORIGIN_BUSY, those of OriginScenes.
  Result<bool> publish(SceneRecord& record, const Precondition& precondition);
  /// Removes a scene from the origin. Returns the revision of the removal; 0 if the origin has no
  /// such scene.
  Result<std::uint64_t> publish_removal(const std::string& id, const Precondition& precondition);
  /// Checks a precondition of a change against the content in the origin.
  Status check_newest(const std::string& id, const Generation& newest,
                      const Precondition& precondition);
  /// Removes a scene that the origin no longer has, if the content here is older than `revision`.
  void drop_removed(const std::string& id, std::uint64_t revision);
  /// Removes the least recently used scene other than `id` from this store. Returns false if there
  /// is none.
  bool evict_other_than(const std::string& id);
  void make_room_for(const std::string& id, std::uint64_t bytes);
  void refresh_from_origin();
  void follow_origin();
  void load_upload(const LoadPointer& load);
  Result<std::shared_ptr<const Scene>> read_upload(SceneLoad& load, const std::string& sha256);
  void run_fetch(const LoadPointer& load, const SceneFetch& source);
  void push_load(const LoadPointer& load);
  /// Fails the load if there is no memory for the queue or the job.
  template <class Job>
  void push_job(WorkQueue& queue, const LoadPointer& load, Job job) {
    try {
      queue.push(WorkQueue::Lane::kRequest, std::move(job));
    } catch (const std::bad_alloc&) {
      fail_without_memory(load);
    }
  }
  /// Calls the loader, and turns its exceptions into an Error.
  Result<std::shared_ptr<const Scene>> run_loader(const LoadInput& input) const;
  /// True if a load or an upload makes a content that is newer than `revision`.
  static bool is_renewed(const Entry& entry, std::uint64_t revision);
  /// Removes a scene from this store and its data folder. Precondition: commit_mutex_ is held.
  /// `removed` receives the content, to be released without a lock. With `removal`, the revision of
  /// a removal in the origin, a scene that is_renewed stays in the store.
  Status drop(const std::string& id, SceneSnapshot& removed,
              std::optional<std::uint64_t> removal = {});
  /// Makes `next` the content of the load's name, durably, and ends the load.
  void commit(const LoadPointer& load, StoredScene next);
  /// Ends a load whose content a later load has already replaced. Preconditions: commit_mutex_ is
  /// held, and the load is not ended.
  void end_replaced(const LoadPointer& load, StoredScene next);
  void fail(const LoadPointer& load, const Error& error);
  /// Fails a load without allocating memory.
  void fail_without_memory(const LoadPointer& load) noexcept;
  /// Drops an unfinished upload without reporting an error.
  void abandon(const LoadPointer& load);
  /// Marks the load as worked on. Returns false if it has ended already.
  bool enter(const LoadPointer& load);
  bool is_wanted(const LoadPointer& load) const;

  // Preconditions: mutex_ is held.
  /// Waits, with `hold` on mutex_, until the load has an outcome. False at the deadline.
  bool wait_for_outcome(const SceneLoad& load, std::unique_lock<std::mutex>& hold,
                        const Deadline& deadline);
  LoadPointer add_load(Entry& entry, const std::string& id, const SceneChoice& choice,
                       const LoadCount& alive);
  /// Null if the load has ended.
  Entry* entry_of(const SceneLoad& load);
  void end(Entry& entry, SceneLoad& load, Result<Put> outcome);
  /// The loads of the name that began before `load` and have no revision yet, in order.
  static std::vector<LoadPointer> loads_before(const Entry& entry, const SceneLoad& load);
  /// Removes a name that has neither content nor loads.
  void drop_if_bare(const std::string& id);
  static SceneSnapshot snapshot_of(const Entry& entry);
  void note_change();
  void note_error(const Error& error) {
    if (error.code == "STORE_FULL") full_ = true;
    if (error.code == "STORE_IO") failing_ = true;
  }

  const StoreOptions options_;
  const SceneLoader loader_;
  std::unique_ptr<SceneFolder> folder_;
  const std::shared_ptr<UploadMemory> uploads_ =
      std::make_shared<UploadMemory>(options_.uploads_memory);
  const LoadCount requests_alive_ = std::make_shared<std::atomic<std::size_t>>(0);
  const LoadCount starts_alive_ = std::make_shared<std::atomic<std::size_t>>(0);

  mutable std::mutex mutex_;  ///< protects the members below; never held during file access
  mutable std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  std::map<std::string, Entry, std::less<>> entries_;
  std::uint64_t next_number_ = 1;
  std::size_t starts_left_ = 0;
  std::uint64_t loads_ready_ = 0, loads_failed_ = 0, loads_cancelled_ = 0;

  std::atomic<bool> full_{false}, failing_{false}, is_origin_failing_{false};
  /// Contents in the origin, as they were last seen; with numbers of contents that stand.
  std::map<std::string, std::uint64_t, std::less<>> stored_;
  /// Names that the origin lacked when it was asked, and when that was.
  std::map<std::string, Deadline::Clock::time_point, std::less<>> absent_;
  std::optional<Error> origin_error_;  ///< of the last request for a newest content
  Deadline::Clock::time_point asks_again_;
  std::uint64_t next_use_ = 1;
  bool stopping_ = false;

  std::mutex change_mutex_;    ///< serialises changes of nodes; locked before commit_mutex_
  std::mutex commit_mutex_;    ///< orders loads and removals equally on disk and in memory
  RevisionCounter revisions_;  ///< protected by commit_mutex_
  // Last, because their threads use the members above; threads of fetches_ use builds_.
  std::optional<WorkQueue> builds_, fetches_;
  std::thread follower_;
};

}  // namespace sightline
