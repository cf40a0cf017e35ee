/// How a store follows an origin: what it takes from it, and what it makes in it.

#include <fcntl.h>

#include <algorithm>
#include <future>
#include <utility>

#include "core/base/free_memory.h"
#include "core/store/scene_id.h"
#include "core/store/scene_store.h"

namespace sightline {
namespace {

constexpr const char* kMark = "origin";
constexpr const char* kDoing = "mark the data folder as a cache";
constexpr const char* kCopying = "copy a scene from the origin";
/// How often the thread of a fetch checks whether its load was cancelled.
constexpr std::chrono::milliseconds kChecksAgain{50};
/// A name of an origin is a URL or a path.
constexpr std::size_t kMostName = 4096;
/// Writers that are overtaken so often in a row give up.
constexpr int kMostTries = 100;
/// How long it is believed that the origin lacks a name, and of how many names.
constexpr std::chrono::milliseconds kAbsentFor{1'000};
constexpr std::size_t kMostAbsent = 10'000;
/// How long an origin that failed is not asked on behalf of another request.
constexpr std::chrono::milliseconds kAsksAgain{500};

bool is_ready(const SceneSnapshot& scene) { return scene && scene->scene; }

/// The scene stands in the origin: another server may have room for it.
Error full_cache(Error error) {
  if (error.code != "STORE_FULL") return error;
  return {ErrorKind::kBusy, "CACHE_FULL", "this server has no room: " + error.message, ""};
}

bool has_files_of(const SceneRecord& a, const SceneRecord& b) {
  const auto is_same = [](const NeighbourRecord& x, const NeighbourRecord& y) {
    return x.name == y.name && x.sha256 == y.sha256;
  };
  return a.sha256 == b.sha256 && a.scene == b.scene &&
         std::equal(a.neighbours.begin(), a.neighbours.end(), b.neighbours.begin(),
                    b.neighbours.end(), is_same);
}

}  // namespace

Status SceneStore::check_cache(bool has_scenes) const {
  const auto path = options_.folder / kMark;
  std::error_code error;
  const bool is_marked = std::filesystem::exists(path, error);
  if (error) return io_error(kDoing, error.value());
  const auto refuse = [](std::string message) {
    return Error{ErrorKind::kConflict, "STORE_IS_CACHE", std::move(message), ""};
  };
  const std::string& name = options_.shared.name;
  if (!options_.shared.origin) {
    if (!is_marked) return success();
    return refuse("the data folder is a cache of an origin: name it with --origin");
  }
  if (is_marked) {
    const auto text = read_small_file(path, kMostName, kDoing);
    if (!text) return text.error();
    if (*text == name) return success();
    return refuse("the data folder is a cache of another origin: choose an empty folder");
  }
  if (has_scenes) {
    return refuse(
        "the data folder has scenes of its own, which the origin may lack: choose an empty folder "
        "and upload them");
  }
  auto temporary = folder_->new_temporary();
  if (!temporary) return std::move(temporary).error();
  return write_durably(*temporary, name, path, kDoing);
}

bool SceneStore::has(const std::string& id, std::uint64_t minimum) const {
  const std::lock_guard hold(mutex_);
  return has_now(id, minimum);
}

bool SceneStore::has_now(const std::string& id, std::uint64_t minimum) const {
  if (!options_.shared.origin) return true;
  const auto found = entries_.find(id);
  if (found == entries_.end()) return false;
  const StoredScene& content = *found->second.content;
  // A scene of the command line is this server's own.
  return content.scene && (content.revision >= minimum || !content.persistent);
}

Result<SceneSnapshot> SceneStore::obtain(const std::string& id, std::uint64_t minimum,
                                         const Deadline& deadline) {
  if (std::unique_lock hold(mutex_); has_now(id, minimum)) {
    const auto found = entries_.find(id);
    if (found == entries_.end()) return SceneSnapshot();
    found->second.used = next_use_++;
    return snapshot_of(found->second);
  }
  return catch_up(id, minimum, deadline);
}

Result<SceneSnapshot> SceneStore::catch_up(const std::string& id, std::uint64_t minimum,
                                           const Deadline& deadline) {
  if (!is_scene_id(id)) return SceneSnapshot();
  {
    const std::lock_guard hold(mutex_);
    const auto absent = absent_.find(id);
    const bool is_recent =
        absent != absent_.end() && Deadline::Clock::now() - absent->second < kAbsentFor;
    if (is_recent && minimum == 0 && !entries_.contains(id)) return SceneSnapshot();
    // Workers do not wait one after the other for an origin that is down.
    if (origin_error_ && Deadline::Clock::now() < asks_again_) return *origin_error_;
  }
  const SceneSnapshot present = find(id);
  const auto newest = options_.shared.origin->newest(id, is_ready(present) ? present->revision : 0);
  {
    const std::lock_guard hold(mutex_);
    origin_error_.reset();
    if (!newest) {
      origin_error_ = newest.error();
      asks_again_ = Deadline::Clock::now() + kAsksAgain;
    }
  }
  if (!newest) return newest.error();
  if (newest->number < minimum) {
    return Error{ErrorKind::kConflict, "REVISION_UNKNOWN",
                 "no content of the scene has the revision " + std::to_string(minimum) +
                     ": the newest is " + std::to_string(newest->number),
                 ""};
  }
  if (!newest->stands()) {
    if (newest->removed) drop_removed(id, newest->number);
    const std::lock_guard hold(mutex_);
    if (absent_.size() >= kMostAbsent) absent_.clear();
    absent_[id] = Deadline::Clock::now();
    const auto found = entries_.find(id);
    return found == entries_.end() ? nullptr : snapshot_of(found->second);
  }
  if (is_ready(present) && present->revision >= newest->number) return present;
  const LoadPointer load = load_from_origin(id, newest->number);
  std::unique_lock hold(mutex_);
  const bool has_ended = wait_for_outcome(*load, hold, deadline);
  const auto found = entries_.find(id);
  if (!has_ended) return found == entries_.end() ? nullptr : snapshot_of(found->second);
  if (!*load->outcome_) return full_cache(load->outcome_->error());
  if (found != entries_.end()) found->second.used = next_use_++;
  return load->outcome_->value().scene;
}

SceneStore::LoadPointer SceneStore::load_from_origin(const std::string& id,
                                                     std::uint64_t revision) {
  LoadPointer load;
  {
    const std::lock_guard hold(mutex_);
    Entry& entry = entries_[id];
    for (const LoadPointer& each : entry.loads) {
      if (each->generation_ >= revision) return each;
    }
    load = add_load(entry, id, {}, starts_alive_);
    load->generation_ = revision;
    load->awaited_ = false;
  }
  push_job(*fetches_, load, [this, load] { guarded(load, [&] { fetch_from_origin(load); }); });
  return load;
}

void SceneStore::fetch_from_origin(const LoadPointer& load) {
  if (!enter(load)) return;
  load->progress_.begin("fetching");
  const auto record = options_.shared.origin->read_record(load->id_, load->generation_);
  if (!record) return fail(load, record.error());
  make_room_for(load->id_, record->bytes);
  load_fetched(*record, load);
  give_back_free_memory_of(record->bytes);
}

void SceneStore::load_fetched(const SceneRecord& record, const LoadPointer& load) {
  auto fetched = fetch_files(record, load);
  while (!fetched && fetched.error().code == "STORE_FULL" && evict_other_than(load->id_)) {
    fetched = fetch_files(record, load);
  }
  if (!fetched) {
    note_error(fetched.error());
    return fail(load, fetched.error());
  }
  const auto files = std::make_shared<const RecordFiles>(std::move(fetched->files));
  auto loading = std::make_shared<std::packaged_task<LoadedScene()>>(
      [this, load, files, record] { return run_fetched(record, *files, load); });
  auto loaded = loading->get_future();
  push_job(*builds_, load, [task = std::move(loading)] { (*task)(); });
  // The cache stores the copies while the scene is loaded: neither needs the other.
  const Status stored = store_in_cache(record, fetched->copies, *load);
  if (!stored) {
    note_error(stored.error());
    fail(load, stored.error());
    return load->progress_.cancel();
  }
  // A stop or a removal does not wait for loads that are queued before this one.
  while (loaded.wait_for(kChecksAgain) != std::future_status::ready) {
    if (load->progress_.cancelled()) return fail(load, load_cancelled());
  }
  auto scene = loaded.get();
  if (!scene) return fail(load, scene.error());
  end_fetch(record, load, std::move(*scene));
}

Result<FileBytes> SceneStore::copy_file(const std::string& sha256, std::uint64_t bytes,
                                        SceneLoad& load, const FileDescriptor& copy) {
  const Error damaged =
      origin_damaged("a file of the scene in the origin has other bytes than its name says");
  const auto fill = [&](std::span<std::byte> room) -> Status {
    BackgroundSha256 hash;
    std::size_t size = 0;
    Status read =
        options_.shared.origin->read_bytes(sha256, [&](std::span<const std::byte> piece) -> Status {
          if (load.progress_.cancelled()) return load_cancelled();
          if (piece.size() > room.size() - size) return damaged;
          std::copy(piece.begin(), piece.end(), room.subspan(size).begin());
          size += piece.size();
          hash.update(piece);
          load.progress_.reach(size);
          return write_all(copy, piece, kCopying);
        });
    const std::string found = hash.finish();
    if (!read) return read;
    return size == bytes && found == sha256 ? success() : damaged;
  };
  return FileBytes::make(bytes, kCopying, fill, options_.overflow_for);
}

Result<FetchedFiles> SceneStore::fetch_files(const SceneRecord& record, const LoadPointer& load) {
  FetchedFiles fetched;
  if (const auto present = folder_->read_record(record.id);
      present && has_files_of(*present, record)) {
    SceneFolder::File failed;
    auto files = read_files(record, failed);
    if (files) {
      fetched.files = std::move(*files);
      return fetched;
    }
    if (!is_damage(files.error())) return std::move(files).error();
    note_error(files.error());
  }
  load->progress_.begin("fetching", record.bytes);
  const auto copy = [&](const std::string& sha256, std::uint64_t bytes) -> Result<FileBytes> {
    auto temporary = folder_->new_temporary();
    if (!temporary) return std::move(temporary).error();
    auto read = copy_file(sha256, bytes, *load, temporary->file());
    if (read) fetched.copies.push_back(std::move(*temporary));
    return read;
  };
  auto bytes = copy(record.sha256, record.bytes);
  if (!bytes) return std::move(bytes).error();
  fetched.files.bytes = std::make_shared<const FileBytes>(std::move(*bytes));
  for (const NeighbourRecord& each : record.neighbours) {
    auto neighbour = copy(each.sha256, each.bytes);
    if (!neighbour) return std::move(neighbour).error();
    // There may be thousands of them, and fewer descriptors.
    fetched.copies.back().close();
    fetched.files.neighbours.add(each.name, std::move(*neighbour));
  }
  return fetched;
}

Status SceneStore::store_in_cache(const SceneRecord& record, std::vector<TemporaryFile>& copies,
                                  SceneLoad& load) {
  const std::lock_guard commit(commit_mutex_);
  // A removal cancels the load under this lock.
  if (load.progress_.cancelled()) return load_cancelled();
  const auto now = folder_->read_record(record.id);
  if (now && now->revision >= record.revision) return success();
  if (copies.empty()) {
    if (now && has_files_of(*now, record)) return folder_->amend(record);
    return Error{ErrorKind::kBusy, "ORIGIN_BUSY", "the scene is being replaced: try again", ""};
  }
  std::vector<TemporaryFile*> neighbours;
  for (std::size_t i = 1; i < copies.size(); ++i) neighbours.push_back(&copies[i]);
  return folder_->commit(copies[0], neighbours, record);
}

SceneStore::LoadedScene SceneStore::run_fetched(const SceneRecord& record, const RecordFiles& files,
                                                const LoadPointer& load) {
  auto scene = run_record(record, files, *load);
  while (!scene && scene.error().code == "SCENE_OVER_BUDGET" && evict_other_than(load->id_)) {
    scene = run_record(record, files, *load);
  }
  files.bytes->drop_unclaimed();
  return scene;
}

void SceneStore::end_fetch(const SceneRecord& record, const LoadPointer& load,
                           std::shared_ptr<const Scene> scene) {
  SceneSnapshot replaced;  // goes last: to let go of a scene takes long
  const std::lock_guard hold(mutex_);
  Entry* const entry = entry_of(*load);
  if (entry == nullptr) return;
  if (!entry->content->scene || entry->content->revision < record.revision) {
    StoredScene next = stored_scene_of(record);
    next.state = SceneState::kReady;
    next.scene = std::move(scene);
    replaced = std::exchange(entry->content, std::make_shared<const StoredScene>(std::move(next)));
    entry->standing = std::max(entry->standing, load->number_);
    entry->used = next_use_++;
    stored_[load->id_] = record.revision;
  }
  end(*entry, *load, Put{entry->content, false});
}

Status SceneStore::store_in_origin(SceneLoad& load, const std::string& sha256) {
  OriginScenes& origin = *options_.shared.origin;
  Status status = origin.store_bytes(sha256, load.upload_->file()->file(), load.upload_->size());
  if (!status || !load.neighbours_) return status;
  const auto records = load.neighbours_->records();
  const auto files = load.neighbours_->files();
  for (std::size_t i = 0; i < files.size() && status; ++i) {
    const auto file = open_file(files[i]->path(), O_RDONLY, "store a scene in the origin");
    if (!file) return file.error();
    status = origin.store_bytes(records[i].sha256, *file, records[i].bytes);
  }
  return status;
}

Status SceneStore::check_newest(const std::string& id, const Generation& newest,
                                const Precondition& precondition) {
  if (!precondition.match && !precondition.none_match) return success();
  if (!newest.stands()) return precondition.check("");
  const SceneSnapshot present = find(id);
  if (is_ready(present) && present->revision == newest.number) {
    return precondition.check(present->etag);
  }
  const auto record = options_.shared.origin->read_record(id, newest.number);
  if (!record) return record.error();
  return precondition.check(stored_scene_of(*record).etag);
}

Result<bool> SceneStore::publish(SceneRecord& record, const Precondition& precondition) {
  std::uint64_t known = 0;
  for (int tries = 0; tries < kMostTries; ++tries) {
    const auto newest = options_.shared.origin->newest(record.id, known);
    if (!newest) return newest.error();
    known = newest->number;
    if (Status status = check_newest(record.id, *newest, precondition); !status) {
      return std::move(status).error();
    }
    record.revision = newest->number + 1;
    const auto published = options_.shared.origin->publish(record);
    if (!published) return published.error();
    if (*published) return !newest->stands();
  }
  return Error{ErrorKind::kBusy, "ORIGIN_BUSY", "other servers change the scene at this moment",
               ""};
}

Result<std::uint64_t> SceneStore::publish_removal(const std::string& id,
                                                  const Precondition& precondition) {
  std::uint64_t known = 0;
  for (int tries = 0; tries < kMostTries; ++tries) {
    const auto newest = options_.shared.origin->newest(id, known);
    if (!newest) return newest.error();
    known = newest->number;
    if (Status status = check_newest(id, *newest, precondition); !status) {
      return std::move(status).error();
    }
    if (!newest->stands()) return std::uint64_t{0};
    const auto published = options_.shared.origin->publish_removal(id, known + 1);
    if (!published) return published.error();
    if (*published) return known + 1;
  }
  return Error{ErrorKind::kBusy, "ORIGIN_BUSY", "other servers change the scene at this moment",
               ""};
}

void SceneStore::drop_removed(const std::string& id, std::uint64_t revision) {
  SceneSnapshot removed;
  const std::lock_guard commit(commit_mutex_);
  {
    const std::lock_guard hold(mutex_);
    stored_.erase(id);
    const auto found = entries_.find(id);
    if (found == entries_.end()) return;
    const StoredScene& content = *found->second.content;
    const bool is_own = content.scene && !content.persistent;
    if (is_own || content.revision >= revision) return;
    if (is_renewed(found->second, revision)) return;
  }
  if (Status status = drop(id, removed, revision); !status) note_error(status.error());
}

bool SceneStore::evict_other_than(const std::string& id) {
  SceneSnapshot removed;
  const std::lock_guard commit(commit_mutex_);
  std::string oldest;
  {
    const std::lock_guard hold(mutex_);
    std::uint64_t used = 0;
    for (const auto& [name, entry] : entries_) {
      const bool may_go = name != id && entry.content->persistent && entry.loads.empty();
      if (!may_go || (!oldest.empty() && entry.used >= used)) continue;
      oldest = name;
      used = entry.used;
    }
  }
  if (oldest.empty()) return false;
  const Status status = drop(oldest, removed);
  if (!status) note_error(status.error());
  return status.ok();
}

void SceneStore::make_room_for(const std::string& id, std::uint64_t bytes) {
  const std::uint64_t most = options_.shared.cache_bytes;
  if (most == 0) return;
  const auto is_full = [&] {
    const std::lock_guard hold(mutex_);
    std::uint64_t sum = bytes;
    for (const auto& [name, entry] : entries_) {
      if (name != id && entry.content->persistent) sum += entry.content->bytes;
    }
    return sum > most;
  };
  while (is_full() && evict_other_than(id)) {
  }
}

void SceneStore::refresh_from_origin() {
  const auto newest = options_.shared.origin->newest_of_all();
  if (!newest) {
    if (!is_origin_failing_.exchange(true)) {
      options_.shared.report("the origin fails: " + newest.error().code + ": " +
                             newest.error().message);
    }
    return;
  }
  if (is_origin_failing_.exchange(false)) options_.shared.report("the origin works again");
  std::vector<std::pair<std::string, Generation>> changed;
  {
    const std::lock_guard hold(mutex_);
    stored_.clear();
    for (const auto& [id, generation] : *newest) {
      if (generation.stands()) stored_[id] = generation.number;
      const auto found = entries_.find(id);
      if (found == entries_.end()) continue;
      const StoredScene& content = *found->second.content;
      const bool is_old = content.persistent && content.revision < generation.number;
      // A start that found damaged files has deleted them.
      const bool is_lost = !content.scene && content.failure && is_damage(*content.failure);
      if (is_old || is_lost) changed.emplace_back(id, generation);
    }
  }
  for (const auto& [id, generation] : changed) {
    if (generation.removed) {
      drop_removed(id, generation.number);
    } else {
      load_from_origin(id, generation.number);
    }
  }
}

void SceneStore::follow_origin() {
  std::unique_lock hold(mutex_);
  while (!stopping_) {
    hold.unlock();
    try {
      refresh_from_origin();
    } catch (const std::bad_alloc&) {
      // The next attempt may find memory.
    }
    hold.lock();
    const auto next = Deadline::Clock::now() + options_.shared.refresh;
    changed_.wait_until(hold, next, [&] { return stopping_; });
  }
}

}  // namespace sightline
