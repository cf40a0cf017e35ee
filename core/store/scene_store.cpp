#include "core/store/scene_store.h"

#include <algorithm>
#include <atomic>
#include <new>

#include "core/store/free_memory.h"
#include "core/store/scene_id.h"

namespace sightline {
namespace {

/// Whether its first content is still on its way.
bool is_waiting(const StoredScene& scene) {
  return scene.state == SceneState::kQueued || scene.state == SceneState::kLoading;
}

/// A name whose content is still to come.
StoredScene queued_scene(const std::string& id) {
  StoredScene scene;
  scene.id = id;
  return scene;
}

std::string tag_of(const std::string& sha256, const SceneChoice& choice) {
  return choice.scene ? sha256 + "-scene-" + std::to_string(*choice.scene) : sha256;
}

}  // namespace

const char* scene_state_name(SceneState state) {
  switch (state) {
    case SceneState::kQueued:
      return "queued";
    case SceneState::kLoading:
      return "loading";
    case SceneState::kReady:
      return "ready";
    case SceneState::kFailed:
      return "failed";
  }
  return "";
}

/// The right to load one scene; waits until there is one. What the load needed for itself goes back
/// to the system at its end.
class SceneStore::LoadSlot {
 public:
  explicit LoadSlot(SceneStore& store) : store_(store) {
    std::unique_lock hold(store_.mutex_);
    store_.slot_free_.wait(hold, [&] { return store_.loads_ < store_.options_.loads_at_once; });
    ++store_.loads_;
  }
  LoadSlot(const LoadSlot&) = delete;
  LoadSlot& operator=(const LoadSlot&) = delete;
  ~LoadSlot() {
    {
      const std::lock_guard hold(store_.mutex_);
      --store_.loads_;
    }
    store_.slot_free_.notify_one();
    give_back_free_memory();
  }

 private:
  SceneStore& store_;
};

SceneStore::SceneStore(const StoreOptions& options, SceneLoader loader)
    : options_(options), loader_(std::move(loader)) {}

Result<std::unique_ptr<SceneStore>> SceneStore::open(const StoreOptions& options,
                                                     SceneLoader loader,
                                                     std::vector<Preload> preloads) {
  for (const Preload& preload : preloads) {
    if (!is_scene_id(preload.id)) return scene_id_invalid();
  }
  std::unique_ptr<SceneStore> store(new SceneStore(options, std::move(loader)));
  SceneFolder::Catalogue catalogue;
  if (!options.folder.empty()) {
    auto folder = SceneFolder::open(options.folder);
    if (!folder) return std::move(folder).error();
    store->folder_ = std::move(*folder);
    catalogue = store->folder_->read_catalogue();
    std::uint64_t seen = 0;
    for (const SceneRecord& record : catalogue.records) seen = std::max(seen, record.revision);
    store->revisions_ = RevisionCounter(options.folder, seen);
  }

  // No thread runs yet; the lock of add() is free.
  std::vector<std::function<void()>> jobs;
  for (SceneFolder::Damage& damage : catalogue.damaged) {
    const std::uint64_t ticket = store->add(queued_scene(damage.id));
    store->fail(damage.id, ticket,
                {ErrorKind::kInternal, "STORE_DAMAGED",
                 std::move(damage.reason) + "; it was moved to quarantine", ""});
  }
  for (SceneRecord& record : catalogue.records) {
    StoredScene scene = queued_scene(record.id);
    scene.revision = record.revision;
    scene.sha256 = record.sha256;
    scene.etag = tag_of(record.sha256, {record.scene});
    scene.chosen = record.scene;
    scene.bytes = record.bytes;
    scene.persistent = true;
    const std::uint64_t ticket = store->add(std::move(scene));
    jobs.push_back([self = store.get(), ticket, record = std::move(record)] {
      self->load_record(record, ticket);
    });
  }
  for (Preload& preload : preloads) {
    const std::uint64_t ticket = store->add(queued_scene(preload.id));
    if (ticket == 0) continue;
    jobs.push_back([self = store.get(), ticket, preload = std::move(preload)] {
      self->load_preload(preload, ticket);
    });
  }
  store->load_in_background(std::move(jobs));
  return store;
}

SceneStore::~SceneStore() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) thread.join();
}

void SceneStore::load_in_background(std::vector<std::function<void()>> jobs) {
  jobs_left_ = jobs.size();
  const auto threads = std::min<std::size_t>(
      jobs.size(), static_cast<std::size_t>(std::max(options_.loads_at_once, 1)));
  const auto shared = std::make_shared<const std::vector<std::function<void()>>>(std::move(jobs));
  const auto next = std::make_shared<std::atomic<std::size_t>>(0);
  for (std::size_t i = 0; i < threads; ++i) {
    threads_.emplace_back([this, shared, next] {
      for (std::size_t job = (*next)++; job < shared->size(); job = (*next)++) {
        {
          const std::lock_guard hold(mutex_);
          if (stopping_) return;
        }
        {
          const LoadSlot slot(*this);
          (*shared)[job]();
        }
        const std::lock_guard hold(mutex_);
        --jobs_left_;
      }
    });
  }
}

Result<std::shared_ptr<const Scene>> SceneStore::load(std::span<const std::byte> bytes,
                                                      const SceneChoice& choice) const {
  try {
    auto scene = loader_(bytes, choice);
    if (scene) *scene = giving_back_memory(std::move(*scene));
    return scene;
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left for the scene",
                 ""};
  } catch (...) {
    return Error{ErrorKind::kInternal, "SCENE_LOAD_FAILED", "the scene could not be loaded", ""};
  }
}

std::uint64_t SceneStore::add(StoredScene scene) {
  const std::lock_guard hold(mutex_);
  std::string id = scene.id;
  const auto [place, added] = entries_.try_emplace(std::move(id));
  if (!added) return 0;
  place->second = {std::make_shared<const StoredScene>(std::move(scene)), next_ticket_++};
  return place->second.ticket;
}

bool SceneStore::advance(const std::string& id, std::uint64_t ticket,
                         const std::function<void(StoredScene&)>& change) {
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end() || found->second.ticket != ticket) return false;
  if (!is_waiting(*found->second.snapshot)) return false;
  StoredScene next = *found->second.snapshot;
  change(next);
  found->second.snapshot = std::make_shared<const StoredScene>(std::move(next));
  return true;
}

void SceneStore::fail(const std::string& id, std::uint64_t ticket, const Error& error) {
  const bool failed = advance(id, ticket, [&](StoredScene& scene) {
    scene.state = SceneState::kFailed;
    scene.failure = error;
  });
  if (failed && options_.report) options_.report(id, error);
}

void SceneStore::give_up(const std::string& id, std::uint64_t ticket) {
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end() || found->second.ticket != ticket) return;
  if (is_waiting(*found->second.snapshot)) entries_.erase(found);
}

SceneSnapshot SceneStore::find(const std::string& id) const {
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : found->second.snapshot;
}

std::vector<SceneSnapshot> SceneStore::list() const {
  const std::lock_guard hold(mutex_);
  std::vector<SceneSnapshot> scenes;
  scenes.reserve(entries_.size());
  for (const auto& [id, entry] : entries_) scenes.push_back(entry.snapshot);
  return scenes;
}

bool SceneStore::settled() const {
  const std::lock_guard hold(mutex_);
  return jobs_left_ == 0;
}

Result<SceneUpload> SceneStore::begin_upload() {
  if (!folder_) return SceneUpload();
  auto file = folder_->new_temporary();
  if (!file) return std::move(file).error();
  return SceneUpload(std::move(*file));
}

Result<std::shared_ptr<const Scene>> SceneStore::load_upload(const std::string& id,
                                                             std::uint64_t ticket,
                                                             SceneUpload& upload,
                                                             const SceneChoice& choice) {
  const LoadSlot slot(*this);
  if (ticket != 0) {
    advance(id, ticket, [](StoredScene& scene) { scene.state = SceneState::kLoading; });
  }
  if (!upload.file()) {
    auto scene = load(upload.memory(), choice);
    upload.forget_memory();
    return scene;
  }
  auto mapped = MappedFile::map(upload.file()->file(), "read the scene's bytes");
  if (!mapped) return std::move(mapped).error();
  return load(mapped->bytes(), choice);
}

Result<SceneStore::Put> SceneStore::put(const std::string& id, SceneUpload upload,
                                        const SceneChoice& choice) {
  if (!is_scene_id(id)) return scene_id_invalid();
  StoredScene next = queued_scene(id);
  next.sha256 = upload.finish_hash();
  next.etag = tag_of(next.sha256, choice);
  next.chosen = choice.scene;
  next.bytes = upload.size();
  next.persistent = folder_ != nullptr;
  if (next.sha256.empty()) {
    return Error{ErrorKind::kInternal, "HASH_FAILED", "the scene's SHA-256 could not be computed",
                 ""};
  }

  // A new name is seen as queued from now on; an old one keeps its content until the end.
  StoredScene queued = next;
  const std::uint64_t ticket = add(std::move(queued));
  auto scene = load_upload(id, ticket, upload, choice);
  if (!scene) {
    give_up(id, ticket);
    return std::move(scene).error();
  }

  const std::lock_guard commit(commit_mutex_);
  const SceneSnapshot before = find(id);
  const bool created = !before || before->revision == 0;
  const auto revision = revisions_.next();
  if (!revision) {
    give_up(id, ticket);
    return revision.error();
  }
  next.revision = *revision;
  next.state = SceneState::kReady;
  next.scene = std::move(*scene);
  if (folder_) {
    const SceneRecord record{id, next.sha256, next.bytes, next.revision, choice.scene};
    if (Status status = folder_->commit(*upload.file(), record); !status) {
      give_up(id, ticket);
      return std::move(status).error();
    }
  }
  const auto snapshot = std::make_shared<const StoredScene>(std::move(next));
  const std::lock_guard hold(mutex_);
  entries_[id] = {snapshot, next_ticket_++};
  return Put{snapshot, created};
}

Status SceneStore::remove(const std::string& id) {
  const std::lock_guard commit(commit_mutex_);
  const SceneSnapshot now = find(id);
  if (!now) return Error{ErrorKind::kNotFound, "SCENE_NOT_FOUND", "there is no such scene", ""};
  if (is_waiting(*now)) {
    return Error{ErrorKind::kConflict, "SCENE_LOADING", "the scene is still loading", ""};
  }
  if (folder_) {
    if (Status status = folder_->remove(id); !status) return status;
  }
  const std::lock_guard hold(mutex_);
  entries_.erase(id);
  return success();
}

}  // namespace sightline
