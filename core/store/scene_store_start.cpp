/// What a store loads at its start, on its own threads.

#include "core/store/free_memory.h"
#include "core/store/scene_store.h"

namespace sightline {

void SceneStore::load_record(const SceneRecord& record, std::uint64_t ticket) {
  const auto begin = [](StoredScene& scene) { scene.state = SceneState::kLoading; };
  if (!advance(record.id, ticket, begin)) return;
  auto mapped = folder_->map(record);
  if (!mapped) {
    // A put may have replaced these bytes while they were read: then they are not damaged, but
    // gone.
    const std::lock_guard commit(commit_mutex_);
    if (!advance(record.id, ticket, begin)) return;
    folder_->quarantine(record);
    Error error = std::move(mapped).error();
    error.message += "; it was moved to quarantine";
    return fail(record.id, ticket, error);
  }
  auto scene = load(mapped->bytes(), {record.scene});
  if (!scene) return fail(record.id, ticket, scene.error());
  advance(record.id, ticket, [&](StoredScene& stored) {
    stored.state = SceneState::kReady;
    stored.scene = std::move(*scene);
  });
}

void SceneStore::load_preload(const Preload& preload, std::uint64_t ticket) {
  if (!advance(preload.id, ticket,
               [](StoredScene& scene) { scene.state = SceneState::kLoading; })) {
    return;
  }
  auto loaded = [&]() -> Result<PreloadedScene> {
    try {
      auto made = preload.load();
      if (made) made->scene = giving_back_memory(std::move(made->scene));
      return made;
    } catch (...) {
      return Error{ErrorKind::kInternal, "SCENE_LOAD_FAILED", "the scene could not be loaded", ""};
    }
  }();
  if (!loaded) return fail(preload.id, ticket, loaded.error());
  const std::lock_guard commit(commit_mutex_);
  const auto revision = revisions_.next();
  if (!revision) return fail(preload.id, ticket, revision.error());
  advance(preload.id, ticket, [&](StoredScene& scene) {
    scene.state = SceneState::kReady;
    scene.revision = *revision;
    scene.sha256 = loaded->sha256;
    scene.etag = loaded->sha256 + (loaded->neighbours.empty() ? "" : "-" + loaded->neighbours);
    scene.bytes = loaded->bytes;
    scene.scene = loaded->scene;
  });
}

}  // namespace sightline
