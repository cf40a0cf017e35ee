/// How a store loads what was uploaded or fetched.

#include <new>

#include "core/base/free_memory.h"
#include "core/store/scene_store.h"

namespace sightline {

Result<std::shared_ptr<const Scene>> SceneStore::run_loader(const LoadInput& input) const {
  if (input.progress.cancelled()) return load_cancelled();
  try {
    auto scene = loader_(input);
    if (scene) *scene = giving_back_memory(std::move(*scene), input.bytes.size());
    return scene;
  } catch (const std::bad_alloc&) {
    return memory_full();
  } catch (...) {
    return Error{ErrorKind::kInternal, "SCENE_LOAD_FAILED", "the scene could not be loaded", ""};
  }
}

std::shared_ptr<SceneLoad> SceneStore::submit(IncomingScene incoming, bool awaited) {
  LoadPointer load = std::move(incoming.load_);
  {
    const std::lock_guard hold(mutex_);
    load->awaited_ = awaited;
  }
  push_load(load);
  return load;
}

void SceneStore::push_load(const LoadPointer& load) {
  std::uint64_t bytes = 0;
  {
    const std::lock_guard hold(mutex_);
    load->busy_ = false;
    load->progress_.begin("waiting");
    if (load->outcome_) load->upload_.reset();
    // From here on a removal may end the upload of a load that waits.
    if (load->upload_) bytes = load->upload_->size();
  }
  push_job(*builds_, load, [this, load, bytes] {
    guarded(load, [&] { load_upload(load); });
    load->let_go();
    give_back_free_memory_of(bytes);
  });
}

Result<std::shared_ptr<SceneLoad>> SceneStore::fetch(const std::string& id,
                                                     const SceneChoice& choice, SceneFetch source,
                                                     bool awaited) {
  auto incoming = begin(id, choice);
  if (!incoming) return std::move(incoming).error();
  LoadPointer load = std::move(incoming->load_);
  {
    const std::lock_guard hold(mutex_);
    load->awaited_ = awaited;
    load->state_ = SceneState::kQueued;
  }
  push_job(*fetches_, load, [this, load, source = std::move(source)] {
    guarded(load, [&] { run_fetch(load, source); });
  });
  return load;
}

void SceneStore::run_fetch(const LoadPointer& load, const SceneFetch& source) {
  if (!enter(load)) return load->upload_.reset();
  IncomingScene incoming(*this, load);
  Status fetched = source(incoming);
  incoming.load_ = nullptr;
  if (fetched) return push_load(load);
  load->upload_.reset();
  fail(load, fetched.error());
}

Result<std::shared_ptr<const Scene>> SceneStore::read_upload(SceneLoad& load,
                                                             const std::string& sha256) {
  LoadInput input{{}, load.choice_, load.progress_};
  if (load.neighbours_) {
    input.neighbour = [&](const std::string& name) { return load.neighbours_->find(name); };
  }
  SceneUpload& upload = *load.upload_;
  std::uint64_t fingerprint = 0;
  auto read = upload.file() ? FileBytes::read(upload.file()->file(), "read the scene's bytes",
                                              fingerprint, options_.overflow_for)
                            : upload.take_memory(options_.overflow_for);
  if (!read) return std::move(read).error();
  const auto owner = std::make_shared<const FileBytes>(std::move(*read));
  load.fingerprint_ = fingerprint;
  input.bytes = owner->bytes();
  input.sha256 = sha256;
  input.owner = owner_of_bytes(owner);
  input.claim = [&](std::span<const std::byte> part) { owner->claim(part); };
  auto scene = run_loader(input);
  owner->drop_unclaimed();
  upload.forget_memory();
  return scene;
}

void SceneStore::load_upload(const LoadPointer& load) {
  if (!enter(load)) return;
  StoredScene next;
  next.id = load->id_;
  next.sha256 = load->upload_->finish_hash();
  next.chosen = load->choice_.scene;
  next.bytes = load->upload_->size();
  const auto scene = [&]() -> Result<std::shared_ptr<const Scene>> {
    if (next.sha256.empty()) {
      return Error{ErrorKind::kInternal, "HASH_FAILED", "the scene's SHA-256 could not be computed",
                   ""};
    }
    if (!load->demanded_sha256_.empty() && load->demanded_sha256_ != next.sha256) {
      return Error{ErrorKind::kInvalid, "SOURCE_HASH_MISMATCH",
                   "the source has the SHA-256 " + next.sha256, "/source/sha256"};
    }
    return read_upload(*load, next.sha256);
  }();
  next.etag = with_neighbours(tag_of(next.sha256, load->choice_),
                              load->neighbours_ ? tag_of(load->neighbours_->records()) : "");
  // Nothing is left of the work when its end is announced.
  if (!scene) load->let_go();
  give_back_free_memory_of(next.bytes);
  if (!scene) return fail(load, scene.error());
  // A stop does not wait for its bytes to be on the disk either.
  if (load->progress_.cancelled()) return fail(load, load_cancelled());
  load->progress_.begin("storing");
  if (options_.shared.origin) {
    if (Status status = store_in_origin(*load, next.sha256); !status) {
      load->let_go();
      return fail(load, status.error());
    }
  }
  next.scene = *scene;
  commit(load, std::move(next));
}

}  // namespace sightline
