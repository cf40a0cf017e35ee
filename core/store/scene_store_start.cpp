/// What a store loads at its start.

#include <limits>
#include <new>

#include "core/base/free_memory.h"
#include "core/store/scene_store.h"

namespace sightline {
namespace {

/// Of what is made or read by somebody else.
constexpr std::uint64_t kUnknownBytes = std::numeric_limits<std::uint64_t>::max();

}  // namespace

void SceneStore::start(const SceneFolder::Catalogue& catalogue, std::vector<Preload> preloads) {
  for (const SceneFolder::Unread& unread : catalogue.unread) {
    StoredScene scene;
    scene.id = unread.id;
    note_error(unread.error);
    fail(add_start(std::move(scene), {}), unread.error);
  }
  for (const SceneRecord& record : catalogue.records) {
    LoadPointer load = add_start(stored_scene_of(record), {record.scene});
    push_start(load, record.bytes, [this, record, load] { load_record(record, load); });
  }
  for (Preload& preload : preloads) {
    StoredScene scene;
    scene.id = preload.id;
    LoadPointer load = add_start(std::move(scene), {});
    if (!load) continue;
    push_start(load, kUnknownBytes,
               [this, preload = std::move(preload), load] { load_preload(preload, load); });
  }
}

SceneStore::LoadPointer SceneStore::add_start(StoredScene scene, const SceneChoice& choice) {
  const std::lock_guard hold(mutex_);
  const auto [place, added] = entries_.try_emplace(scene.id);
  if (!added) return nullptr;
  const std::string id = scene.id;
  place->second.content = std::make_shared<const StoredScene>(std::move(scene));
  LoadPointer load = add_load(place->second, id, choice, starts_alive_);
  load->awaited_ = false;
  return load;
}

void SceneStore::push_start(const LoadPointer& load, std::uint64_t bytes,
                            std::function<void()> job) {
  {
    const std::lock_guard hold(mutex_);
    ++starts_left_;
  }
  builds_->push(WorkQueue::Lane::kStart, [this, load, bytes, job = std::move(job)] {
    guarded(load, job);
    give_back_free_memory_of(bytes);
    const std::lock_guard hold(mutex_);
    --starts_left_;
  });
}

void SceneStore::forget_record(const LoadPointer& load) {
  const std::lock_guard hold(mutex_);
  Entry* const entry = entry_of(*load);
  if (entry == nullptr || entry->standing >= load->number_) return;
  StoredScene next = *entry->content;
  next.sha256.clear();
  next.etag.clear();
  next.bytes = 0;
  next.persistent = false;
  entry->content = std::make_shared<const StoredScene>(std::move(next));
}

Result<RecordFiles> SceneStore::read_files(const SceneRecord& record,
                                           SceneFolder::File& failed) const {
  failed = {record.sha256, record.bytes};
  auto read =
      folder_->read_bytes(record.sha256, record.bytes, record.fingerprint, options_.overflow_for);
  if (!read) return std::move(read).error();
  auto neighbours = StoredNeighbours::read(*folder_, record, failed);
  if (!neighbours) return std::move(neighbours).error();
  return RecordFiles{std::make_shared<const FileBytes>(std::move(*read)), std::move(*neighbours)};
}

Result<RecordFiles> SceneStore::check_record(const SceneRecord& record, const LoadPointer& load) {
  for (;;) {
    SceneFolder::File failed;
    auto files = read_files(record, failed);
    if (files) return files;
    Error error = files.error();
    note_error(error);
    // A put may have replaced these bytes while they were read, or a removal dropped them: then
    // they are not damaged, but gone.
    const std::lock_guard commit(commit_mutex_);
    if (!is_damage(error) || !is_wanted(load)) return error;
    const auto moved = folder_->quarantine(record, failed);
    if (moved && !*moved) continue;
    if (moved) forget_record(load);
    error.message += moved && options_.shared.origin
                         ? "; it was deleted from the cache"
                         : quarantine_note(moved ? success() : moved.error());
    return error;
  }
}

SceneStore::LoadedScene SceneStore::run_record(const SceneRecord& record, const RecordFiles& files,
                                               SceneLoad& load) const {
  return run_loader({files.bytes->bytes(),
                     {record.scene},
                     load.progress_,
                     record.sha256,
                     [&](const std::string& name) { return files.neighbours.find(name); },
                     owner_of_bytes(files.bytes),
                     record.changes,
                     [&](std::span<const std::byte> part) { files.bytes->claim(part); }});
}

void SceneStore::load_record(const SceneRecord& record, const LoadPointer& load) {
  if (!enter(load)) return;
  load->progress_.begin("checking");
  const auto files = check_record(record, load);
  if (!files) return fail(load, files.error());
  auto scene = run_record(record, *files, *load);
  files->bytes->drop_unclaimed();
  if (!scene) return fail(load, scene.error());
  const std::lock_guard hold(mutex_);
  Entry* const entry = entry_of(*load);
  if (entry == nullptr) return;
  if (entry->standing < load->number_) {
    StoredScene next = *entry->content;
    next.state = SceneState::kReady;
    next.scene = std::move(*scene);
    entry->content = std::make_shared<const StoredScene>(std::move(next));
    entry->standing = load->number_;
  }
  end(*entry, *load, Put{entry->content, false});
}

void SceneStore::load_preload(const Preload& preload, const LoadPointer& load) {
  if (!enter(load)) return;
  auto loaded = [&]() -> Result<PreloadedScene> {
    try {
      auto made = preload.load(load->progress_);
      if (made) made->scene = giving_back_memory(std::move(made->scene), kUnknownBytes);
      return made;
    } catch (...) {
      return Error{ErrorKind::kInternal, "SCENE_LOAD_FAILED", "the scene could not be loaded", ""};
    }
  }();
  if (!loaded) return fail(load, loaded.error());
  StoredScene next;
  next.id = load->id_;
  next.sha256 = loaded->sha256;
  next.etag = with_neighbours(loaded->sha256, loaded->neighbours);
  next.bytes = loaded->bytes;
  next.scene = std::move(loaded->scene);
  commit(load, std::move(next));
}

}  // namespace sightline
