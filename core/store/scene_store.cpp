#include "core/store/scene_store.h"

#include <algorithm>
#include <utility>

#include "core/store/scene_id.h"

namespace sightline {
namespace {

/// A name whose content is still to come.
SceneSnapshot bare_scene(const std::string& id) {
  auto scene = std::make_shared<StoredScene>();
  scene->id = id;
  return scene;
}

/// How often a wait checks its deadline's flag, which wakes nobody.
constexpr std::chrono::milliseconds kLook{100};

/// Waits until `done()` or the deadline. The mutex of `hold` guards what done() reads.
template <class Done>
bool wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& hold,
                const Deadline& deadline, const Done& done) {
  while (!done()) {
    if (deadline.passed()) return false;
    changed.wait_until(hold, std::min(deadline.at, Deadline::Clock::now() + kLook));
  }
  return true;
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
    case SceneState::kStored:
      return "stored";
  }
  return "";
}

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
    auto folder = SceneFolder::open(
        options.folder, options.shared.origin ? Durability::kRecords : Durability::kEverything);
    if (!folder) return std::move(folder).error();
    store->folder_ = std::move(*folder);
    auto read = store->folder_->read_catalogue();
    if (!read) return std::move(read).error();
    catalogue = std::move(*read);
    const bool has_scenes = !catalogue.records.empty() || !catalogue.unread.empty();
    if (Status status = store->check_cache(has_scenes); !status) return std::move(status).error();
    std::uint64_t seen = 0;
    for (const SceneRecord& record : catalogue.records) seen = std::max(seen, record.revision);
    auto revisions = RevisionCounter::open(options.folder, seen);
    if (!revisions) return std::move(revisions).error();
    store->revisions_ = std::move(*revisions);
  }
  store->builds_.emplace(options.loads_at_once);
  store->fetches_.emplace(options.fetches_at_once);
  store->start(catalogue, std::move(preloads));
  if (options.shared.origin)
    store->follower_ = std::thread([&self = *store] { self.follow_origin(); });
  return store;
}

SceneStore::~SceneStore() {
  {
    const std::lock_guard hold(mutex_);
    stopping_ = true;
    for (auto& [id, entry] : entries_) {
      for (const LoadPointer& load : entry.loads) load->progress_.cancel();
    }
    changed_.notify_all();
  }
  if (follower_.joinable()) follower_.join();
  fetches_.reset();
  builds_.reset();
}

SceneSnapshot SceneStore::snapshot_of(const Entry& entry) {
  if (entry.loads.empty()) return entry.content;
  const SceneLoad& load = *entry.loads.back();
  auto scene = std::make_shared<StoredScene>(*entry.content);
  if (scene->scene) {
    scene->update = {load.state_, load.progress_.reading(), std::nullopt};
  } else {
    scene->state = load.state_;
    scene->progress = load.progress_.reading();
    scene->failure.reset();
  }
  return scene;
}

SceneSnapshot SceneStore::find(const std::string& id) const {
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : snapshot_of(found->second);
}

std::vector<SceneSnapshot> SceneStore::list() const {
  const std::lock_guard hold(mutex_);
  std::vector<SceneSnapshot> scenes;
  scenes.reserve(entries_.size() + stored_.size());
  for (const auto& [id, entry] : entries_) scenes.push_back(snapshot_of(entry));
  for (const auto& [id, revision] : stored_) {
    if (entries_.contains(id)) continue;
    StoredScene scene;
    scene.id = id;
    scene.state = SceneState::kStored;
    scene.revision = revision;
    scene.persistent = true;
    scenes.push_back(std::make_shared<const StoredScene>(std::move(scene)));
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const SceneSnapshot& a, const SceneSnapshot& b) { return a->id < b->id; });
  return scenes;
}

bool SceneStore::settled() const {
  const std::lock_guard hold(mutex_);
  return starts_left_ == 0;
}

std::vector<std::pair<std::string, std::uint64_t>> SceneStore::load_counts() const {
  const std::lock_guard hold(mutex_);
  return {{"ready", loads_ready_}, {"failed", loads_failed_}, {"cancelled", loads_cancelled_}};
}

std::uint64_t SceneStore::changes() const {
  const std::lock_guard hold(mutex_);
  return changes_;
}

void SceneStore::wait_for_change(std::uint64_t seen, const Deadline& deadline) const {
  std::unique_lock hold(mutex_);
  wait_until(changed_, hold, deadline, [&] { return changes_ != seen; });
}

void SceneStore::note_change() {
  ++changes_;
  changed_.notify_all();
}

SceneStore::LoadPointer SceneStore::add_load(Entry& entry, const std::string& id,
                                             const SceneChoice& choice, const LoadCount& alive) {
  if (!entry.content) entry.content = bare_scene(id);
  auto load = std::make_shared<SceneLoad>(id, choice, next_number_++, alive);
  if (!entry.content->scene) {
    auto failed = std::make_shared<StoredScene>(*entry.content);
    failed->state = SceneState::kFailed;
    failed->failure = memory_full();
    load->failed_ = std::move(failed);
  }
  entry.loads.push_back(std::move(load));
  note_change();
  return entry.loads.back();
}

SceneStore::Entry* SceneStore::entry_of(const SceneLoad& load) {
  const auto found = entries_.find(load.id_);
  if (found == entries_.end()) return nullptr;
  const auto& loads = found->second.loads;
  const bool on_its_way = std::any_of(loads.begin(), loads.end(),
                                      [&](const auto& each) { return each.get() == &load; });
  return on_its_way ? &found->second : nullptr;
}

void SceneStore::end(Entry& entry, SceneLoad& load, Result<Put> outcome) {
  const bool cancelled = !outcome && outcome.error().code == load_cancelled().code;
  ++(outcome ? loads_ready_ : cancelled ? loads_cancelled_ : loads_failed_);
  if (outcome) {
    full_ = false;
  } else if (outcome.error().code == "STORE_FULL") {
    full_ = true;
  }
  load.outcome_ = std::move(outcome);
  const auto same = [&](const auto& each) { return each.get() == &load; };
  entry.loads.erase(std::remove_if(entry.loads.begin(), entry.loads.end(), same),
                    entry.loads.end());
  note_change();
}

std::vector<SceneStore::LoadPointer> SceneStore::loads_before(const Entry& entry,
                                                              const SceneLoad& load) {
  std::vector<LoadPointer> before;
  for (const LoadPointer& each : entry.loads) {
    if (each->number_ < load.number_ && !each->revision_) before.push_back(each);
  }
  return before;
}

void SceneStore::drop_if_bare(const std::string& id) {
  const auto found = entries_.find(id);
  if (found == entries_.end() || !found->second.loads.empty()) return;
  if (!found->second.content || found->second.content->state == SceneState::kQueued)
    entries_.erase(found);
}

Result<IncomingScene> SceneStore::begin(const std::string& id, const SceneChoice& choice) {
  if (!is_scene_id(id)) return scene_id_invalid();
  if (*requests_alive_ >= options_.loads_max) {
    return Error{ErrorKind::kBusy, "LOADS_TOO_MANY",
                 "as many scenes are being loaded as may be: " + std::to_string(options_.loads_max),
                 ""};
  }
  auto upload = begin_upload(folder_.get(), std::make_shared<LoadMemory>(uploads_));
  if (!upload) {
    note_error(upload.error());
    return std::move(upload).error();
  }
  const std::lock_guard hold(mutex_);
  LoadPointer load;
  try {
    load = add_load(entries_[id], id, choice, requests_alive_);
  } catch (...) {
    drop_if_bare(id);
    throw;
  }
  load->upload_.emplace(std::move(*upload));
  load->busy_ = true;
  load->state_ = SceneState::kLoading;
  load->progress_.begin("receiving");
  return IncomingScene(*this, std::move(load));
}

std::optional<Result<Put>> SceneStore::wait(SceneLoad& load, const Deadline& deadline) {
  std::unique_lock hold(mutex_);
  if (wait_for_outcome(load, hold, deadline)) return load.outcome_;
  load.awaited_ = false;
  return std::nullopt;
}

bool SceneStore::wait_for_outcome(const SceneLoad& load, std::unique_lock<std::mutex>& hold,
                                  const Deadline& deadline) {
  return wait_until(changed_, hold, deadline, [&] { return load.outcome_.has_value(); });
}

bool SceneStore::enter(const LoadPointer& load) {
  const std::lock_guard hold(mutex_);
  if (entry_of(*load) == nullptr) return false;
  load->busy_ = true;
  load->state_ = SceneState::kLoading;
  note_change();
  return true;
}

bool SceneStore::is_wanted(const LoadPointer& load) const {
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(load->id_);
  return !load->outcome_ && found != entries_.end() && found->second.standing < load->number_;
}

void SceneStore::fail(const LoadPointer& load, const Error& error) {
  bool told = false;
  {
    const std::lock_guard hold(mutex_);
    Entry* const entry = entry_of(*load);
    if (entry == nullptr) return;
    told = load->awaited_;
    // A failure that is older than the content is of no interest.
    if (!told && entry->standing < load->number_) {
      StoredScene next = *entry->content;
      if (next.scene) {
        next.update = {SceneState::kFailed, {}, error};
      } else {
        next.state = SceneState::kFailed;
        next.failure = error;
      }
      entry->content = std::make_shared<const StoredScene>(std::move(next));
    }
    end(*entry, *load, error);
    drop_if_bare(load->id_);
  }
  // What a stop breaks off has not failed.
  if (!told && options_.report && !load->progress_.cancelled()) options_.report(load->id_, error);
}

void SceneStore::guarded(const LoadPointer& load, const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    fail_without_memory(load);
  }
}

void SceneStore::fail_without_memory(const LoadPointer& load) noexcept {
  load->let_go();
  try {
    return fail(load, memory_full());
  } catch (...) {
    // There is none to say so either.
  }
  const std::lock_guard hold(mutex_);
  Entry* const entry = entry_of(*load);
  if (entry == nullptr) return;
  if (!load->awaited_ && load->failed_) entry->content = std::move(load->failed_);
  // Texts that are short enough need no memory.
  end(*entry, *load, Error{ErrorKind::kOutOfSpace, "MEMORY_FULL", "out of memory", ""});
  drop_if_bare(load->id_);
}

void SceneStore::abandon(const LoadPointer& load) {
  load->upload_.reset();
  const std::lock_guard hold(mutex_);
  Entry* const entry = entry_of(*load);
  if (entry == nullptr) return;
  end(*entry, *load, load_cancelled());
  drop_if_bare(load->id_);
}

void SceneStore::commit(const LoadPointer& load, StoredScene next) {
  // Goes last: to let go of a scene takes long, and nobody shall wait for that.
  SceneSnapshot replaced;
  const std::lock_guard commit(commit_mutex_);
  bool created = false, is_replaced = false;
  std::optional<Error> unmet;
  next.state = SceneState::kReady;
  next.persistent = folder_ && load->upload_;
  const bool is_shared = next.persistent && options_.shared.origin;
  std::vector<LoadPointer> overtaken;
  {
    const std::lock_guard hold(mutex_);
    Entry* const entry = entry_of(*load);
    if (entry == nullptr) return;
    // Before what follows: of two with the same tag the later one to end does not take place. Of
    // what is shared, the origin tells the present content, and the last to end takes place.
    if (!is_shared) {
      if (Status status = load->precondition_.check(entry->content->etag); !status) {
        unmet = std::move(status).error();
      }
      is_replaced = entry->standing > load->number_;
      created = entry->content->revision == 0;
      overtaken = loads_before(*entry, *load);
    }
  }
  // Nothing is left of it when that is announced: there is room again.
  const auto refuse = [&](const Error& error) {
    note_error(error);
    load->let_go();
    fail(load, error);
  };
  if (unmet) return refuse(*unmet);
  if (is_replaced) return end_replaced(load, std::move(next));
  SceneRecord record{next.id, next.sha256, next.bytes, 0, next.chosen};
  record.fingerprint = load->fingerprint_;
  std::vector<TemporaryFile*> neighbours;
  if (load->neighbours_) {
    record.neighbours = load->neighbours_->records();
    neighbours = load->neighbours_->files();
  }
  if (is_shared) {
    const auto published = publish(record, load->precondition_);
    if (!published) return refuse(published.error());
    created = *published;
  } else {
    // Earlier loads get the lower numbers, whenever they end.
    const auto revision = revisions_.next(overtaken.size() + 1);
    if (!revision) return refuse(revision.error());
    record.revision = *revision;
  }
  next.revision = record.revision;
  if (next.persistent) {
    Status status = folder_->commit(*load->upload_->file(), neighbours, record);
    if (!status) return refuse(status.error());
    failing_ = false;
  }
  const auto snapshot = std::make_shared<const StoredScene>(std::move(next));
  const std::lock_guard hold(mutex_);
  for (std::size_t i = 0; i < overtaken.size(); ++i) {
    overtaken[i]->revision_ = record.revision - overtaken.size() + i;
  }
  // Removals wait for commit_mutex_: what was there above is there now.
  Entry& entry = *entry_of(*load);
  replaced = std::exchange(entry.content, snapshot);
  entry.standing = std::max(entry.standing, load->number_);
  if (is_shared) {
    stored_[load->id_] = record.revision;
    absent_.erase(load->id_);
  }
  end(entry, *load, Put{snapshot, created});
}

void SceneStore::end_replaced(const LoadPointer& load, StoredScene next) {
  load->let_go();
  const std::lock_guard hold(mutex_);
  next.revision = load->revision_.value_or(0);
  end(*entry_of(*load), *load, Put{std::make_shared<const StoredScene>(std::move(next)), false});
}

Result<std::uint64_t> SceneStore::remove(const std::string& id, const Precondition& precondition) {
  SceneSnapshot removed;  // goes last, as above
  const std::lock_guard commit(commit_mutex_);
  const SceneSnapshot present = find(id);
  const bool is_own = present && present->scene && !present->persistent;
  const bool is_shared = options_.shared.origin && !is_own;
  std::uint64_t revision = 0;
  if (is_shared) {
    const auto published = publish_removal(id, precondition);
    if (!published) return published.error();
    // Else all that it may have is a load here.
    if (*published == 0 && !present) return scene_not_found();
    revision = *published;
    const std::lock_guard hold(mutex_);
    stored_.erase(id);
  } else {
    if (!present) return scene_not_found();
    if (Status status = precondition.check(present->etag); !status)
      return std::move(status).error();
  }
  if (Status status = drop(id, removed); !status) return std::move(status).error();
  return revision;
}

bool SceneStore::is_renewed(const Entry& entry, std::uint64_t revision) {
  return std::any_of(entry.loads.begin(), entry.loads.end(), [&](const LoadPointer& load) {
    return load->generation_ == 0 || load->generation_ > revision;
  });
}

Status SceneStore::drop(const std::string& id, SceneSnapshot& removed,
                        std::optional<std::uint64_t> removal) {
  if (folder_) {
    if (Status status = folder_->remove(id); !status) {
      note_error(status.error());
      return status;
    }
  }
  const std::lock_guard hold(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return success();  // all that it had was a load, which failed
  if (removal && is_renewed(found->second, *removal)) return success();
  while (!found->second.loads.empty()) {
    const LoadPointer load = found->second.loads.back();
    load->progress_.cancel();
    if (!load->busy_) load->upload_.reset();
    end(found->second, *load, load_cancelled());
  }
  removed = std::move(found->second.content);
  entries_.erase(found);
  note_change();
  return success();
}

}  // namespace sightline
