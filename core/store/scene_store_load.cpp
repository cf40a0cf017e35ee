/// How a store loads what was uploaded.

#include <new>

#include "core/store/free_memory.h"
#include "core/store/scene_store.h"

namespace sightline {

Result<std::shared_ptr<const Scene>> SceneStore::run_loader(const LoadInput& input) const {
  if (input.progress.cancelled()) return load_cancelled();
  try {
    auto scene = loader_(input);
    if (scene) *scene = giving_back_memory(std::move(*scene));
    return scene;
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left for the scene",
                 ""};
  } catch (...) {
    return Error{ErrorKind::kInternal, "SCENE_LOAD_FAILED", "the scene could not be loaded", ""};
  }
}

void SceneStore::load_upload(const LoadPointer& load) {
  if (!enter(load)) return;
  SceneUpload& upload = *load->upload_;
  StoredScene next;
  next.id = load->id_;
  next.sha256 = upload.finish_hash();
  next.etag = tag_of(next.sha256, load->choice_);
  next.chosen = load->choice_.scene;
  next.bytes = upload.size();
  const auto scene = [&]() -> Result<std::shared_ptr<const Scene>> {
    if (next.sha256.empty()) {
      return Error{ErrorKind::kInternal, "HASH_FAILED", "the scene's SHA-256 could not be computed",
                   ""};
    }
    if (!upload.file()) {
      auto loaded = run_loader({upload.memory(), load->choice_, load->progress_});
      upload.forget_memory();
      return loaded;
    }
    auto mapped = MappedFile::map(upload.file()->file(), "read the scene's bytes");
    if (!mapped) return std::move(mapped).error();
    return run_loader({mapped->bytes(), load->choice_, load->progress_, next.sha256});
  }();
  // Nothing is left of the work when its end is announced.
  if (!scene) load->upload_.reset();
  give_back_free_memory();
  if (!scene) return fail(load, scene.error());
  load->progress_.begin("storing");
  next.scene = *scene;
  commit(load, std::move(next));
}

}  // namespace sightline
