#pragma once
/// Named scenes, each an immutable revision that readers share; persistent where there is a data
/// folder. Contents are loaded in the background, a few at once.

#include <atomic>
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
#include <utility>
#include <vector>

#include "core/base/deadline.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/scene/scene.h"
#include "core/store/revision_counter.h"
#include "core/store/scene_folder.h"
#include "core/store/scene_load.h"
#include "core/store/stored_scene.h"
#include "core/store/work_queue.h"

namespace sightline {

struct LoadInput {
  std::span<const std::byte> bytes;  ///< freed when the loader returns, unless there is a `owner`
  SceneChoice choice;
  Progress& progress;       ///< a loader tells its stages, and may end early once it is cancelled
  std::string sha256 = {};  ///< of the bytes; empty where no data folder stores them
  /// The bytes of a file beside the scene's, gone like the others; empty where there are none.
  std::function<Result<std::span<const std::byte>>(const std::string& name)> neighbour = {};
  /// Owns the bytes, which do not change while it is held: they belong to a data folder that only
  /// the store writes. Null: nobody owns them.
  std::shared_ptr<const void> owner = {};
  std::span<const NodeChange> changes = {};  ///< that the scene must apply
  /// Called with each part of the bytes that the scene shares; with a `owner` all others are freed.
  /// May be called from several threads. Empty: nothing is called.
  std::function<void(std::span<const std::byte>)> claim = {};
};
/// Turns the bytes of a file into a scene. Handed in, because this room knows no file format. May
/// be called from several threads at once.
using SceneLoader = std::function<Result<std::shared_ptr<const Scene>>(const LoadInput& input)>;

/// Gets the bytes of a scene from elsewhere, on a thread of the store. Throws nothing.
using SceneFetch = std::function<Status(IncomingScene& incoming)>;

/// A scene that does not come by upload: made or read by `load` on a thread of the store.
struct PreloadedScene {
  std::shared_ptr<const Scene> scene;
  std::string sha256;      ///< of the file
  std::string neighbours;  ///< a hash of what came from other files; empty where nothing did
  std::uint64_t bytes = 0;
};
struct Preload {
  std::string id;
  std::function<Result<PreloadedScene>(Progress& progress)> load;
};

struct StoreOptions {
  std::filesystem::path folder = {};  ///< empty: scenes live in memory only
  int loads_at_once = 2;        ///< building needs several times the memory of the built scene
  int fetches_at_once = 4;      ///< each may have to wait for a slow source
  std::size_t loads_max = 100;  ///< requests to load that are running or waiting
  /// Bytes of all uploads in total, where there is no folder; a single one may be larger.
  std::uint64_t uploads_memory = std::uint64_t{1} << 30;
  /// Told of each load that fails with nobody waiting for it, once; from threads of the store.
  std::function<void(const std::string& id, const Error& error)> report = {};
  /// Shown each scene that is another one's with some nodes changed, before it has a name; the
  /// change fails where this does.
  std::function<Status(const std::shared_ptr<const Scene>& scene)> admit = {};
};

/// May be used from many threads.
class SceneStore {
 public:
  /// Reads the catalogue and starts to load it, then the preloads, in the background: what is
  /// damaged fails by itself and stops nothing. A scene of the catalogue goes before a preload of
  /// the same name. Errors: those of SceneFolder::open, SCENE_ID_INVALID of a preload.
  static Result<std::unique_ptr<SceneStore>> open(const StoreOptions& options, SceneLoader loader,
                                                  std::vector<Preload> preloads);
  /// Cancels what is being loaded, and waits for its threads. Nobody waits for a load any more.
  ~SceneStore();

  /// Null when there is no scene of this name.
  SceneSnapshot find(const std::string& id) const;
  /// Sorted by id.
  std::vector<SceneSnapshot> list() const;
  /// Whether everything that was there at the start is ready or failed.
  bool settled() const;

  /// From here on the name is known as loading, its old content stays until the new one is ready.
  /// Errors: SCENE_ID_INVALID, LOADS_TOO_MANY, those of io_error.
  Result<IncomingScene> begin(const std::string& id, const SceneChoice& choice);
  /// Makes the received content the content of its name, in the background. Readers see the old
  /// revision until the new one is ready and durable. Of several loads at once the last to begin
  /// wins. Each is answered with its own content, with revisions in the order in which they began.
  ///
  /// awaited  whether wait() will be called; if not, a failure is recorded from the beginning
  std::shared_ptr<SceneLoad> submit(IncomingScene incoming, bool awaited = true);
  /// As submit, for bytes that `source` fetches in the background. Errors: as begin.
  Result<std::shared_ptr<SceneLoad>> fetch(const std::string& id, const SceneChoice& choice,
                                           SceneFetch source, bool awaited);
  /// Waits for the outcome: the content is ready and durable, or (LOAD_CANCELLED, errors of the
  /// loader, those of io_error) nothing has changed. Empty at the deadline: then the load goes
  /// on by itself, and its failure will be shown by find(). Call once for each load.
  std::optional<Result<Put>> wait(SceneLoad& load, const Deadline& deadline);
  /// Changes a node of the present content: a new revision, durable where the content is. What is
  /// on its way to the name goes on, and replaces it all the same.
  /// Errors: SCENE_NOT_FOUND, SCENE_LOADING, SCENE_FAILED, PRECONDITION_FAILED, CHANGES_TOO_MANY,
  /// those of Scene::changed, of StoreOptions::admit and of io_error.
  Result<SceneSnapshot> change(const std::string& id, const NodeChange& change,
                               const Precondition& precondition = {});
  /// Also cancels what is on its way to this name. Errors: SCENE_NOT_FOUND, PRECONDITION_FAILED,
  /// those of io_error.
  Status remove(const std::string& id, const Precondition& precondition = {});

  /// Whether there was no space for a scene, and none has become ready since.
  bool is_full() const { return full_; }
  /// Whether the data folder failed (STORE_IO), and nothing was written to it since.
  bool is_failing() const { return failing_; }

  /// How many loads have ended so far, by outcome: "ready", "failed", "cancelled".
  std::vector<std::pair<std::string, std::uint64_t>> load_counts() const;

  /// Counts the changes of states, of all scenes.
  std::uint64_t changes() const;
  /// Returns once changes() is not `seen` any more, or at the deadline.
  void wait_for_change(std::uint64_t seen, const Deadline& deadline) const;

 private:
  friend class IncomingScene;
  using LoadPointer = std::shared_ptr<SceneLoad>;
  using LoadCount = std::shared_ptr<std::atomic<std::size_t>>;

  /// A name's time from its first mention to its removal.
  struct Entry {
    SceneSnapshot content;           ///< never null: at first it says no more than the name
    std::vector<LoadPointer> loads;  ///< on their way, in the order in which they began
    std::uint64_t standing = 0;      ///< the number of the load that the content came by
  };

  SceneStore(const StoreOptions& options, SceneLoader loader);
  void start(SceneFolder::Catalogue catalogue, std::vector<Preload> preloads);
  /// Null when there is a scene of this name already.
  LoadPointer add_start(StoredScene scene, const SceneChoice& choice);
  /// `bytes`: of the file.
  void push_start(const LoadPointer& load, std::uint64_t bytes, std::function<void()> job);
  /// Makes `next` the content of its name if it is still `before`; false if it is not.
  Result<bool> commit_change(const SceneSnapshot& before, StoredScene& next);
  /// Fails the load where the work throws, as it does without memory.
  void guarded(const LoadPointer& load, const std::function<void()>& work);
  void load_record(const SceneRecord& record, const LoadPointer& load);
  /// All files of the record. What is damaged is in quarantine when it returns STORE_DAMAGED, or
  /// the message says why not.
  Result<RecordFiles> check_record(const SceneRecord& record, const LoadPointer& load);
  /// The folder has the scene no more: nor has its name a content.
  void forget_record(const LoadPointer& load);
  void load_preload(const Preload& preload, const LoadPointer& load);
  void load_upload(const LoadPointer& load);
  Result<std::shared_ptr<const Scene>> read_upload(SceneLoad& load, const std::string& sha256);
  void run_fetch(const LoadPointer& load, const SceneFetch& source);
  void push_load(const LoadPointer& load);
  /// Fails the load where there is no memory for a queue, nor for the job itself.
  template <class Job>
  void push_job(WorkQueue& queue, const LoadPointer& load, Job job) {
    try {
      queue.push(WorkQueue::Lane::kRequest, std::move(job));
    } catch (const std::bad_alloc&) {
      fail_without_memory(load);
    }
  }
  /// The border to the loader: what it throws becomes an Error.
  Result<std::shared_ptr<const Scene>> run_loader(const LoadInput& input) const;
  /// Makes `next` the content of the load's name, durably, and ends the load.
  void commit(const LoadPointer& load, StoredScene next);
  /// Ends a load whose content a later one has replaced already. Precondition: commit_mutex_ is
  /// held, and the name has this load.
  void end_replaced(const LoadPointer& load, StoredScene next);
  void fail(const LoadPointer& load, const Error& error);
  /// Takes no memory where there is none.
  void fail_without_memory(const LoadPointer& load) noexcept;
  /// Nothing has come of it, and nobody is told.
  void abandon(const LoadPointer& load);
  /// Marks the load as worked on. False when it has ended already.
  bool enter(const LoadPointer& load);
  bool is_wanted(const LoadPointer& load) const;

  // Precondition for these: mutex_ is held.
  LoadPointer add_load(Entry& entry, const std::string& id, const SceneChoice& choice,
                       const LoadCount& alive);
  /// Null when the load has ended.
  Entry* entry_of(const SceneLoad& load);
  void end(Entry& entry, SceneLoad& load, Result<Put> outcome);
  /// The loads of the name that began before `load` and have no revision, in that order.
  static std::vector<LoadPointer> loads_before(const Entry& entry, const SceneLoad& load);
  /// Forgets a name that never had content and has none on its way.
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

  mutable std::mutex mutex_;  ///< for what follows; never held while a file is touched
  mutable std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  std::map<std::string, Entry, std::less<>> entries_;
  std::uint64_t next_number_ = 1;
  std::size_t starts_left_ = 0;
  std::uint64_t loads_ready_ = 0, loads_failed_ = 0, loads_cancelled_ = 0;

  std::atomic<bool> full_{false}, failing_{false};
  std::mutex change_mutex_;    ///< one change after the other; held before commit_mutex_
  std::mutex commit_mutex_;    ///< disk and memory see puts and removals in the same order
  RevisionCounter revisions_;  ///< under commit_mutex_
  // Last: their threads use what stands above, and those that fetch use those that build.
  std::optional<WorkQueue> builds_, fetches_;
};

}  // namespace sightline
