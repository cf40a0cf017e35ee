#include "core/store/scene_load.h"

#include "core/store/scene_store.h"

namespace sightline {

IncomingScene::~IncomingScene() {
  if (load_) store_->abandon(load_);
}

Status IncomingScene::append(std::span<const std::byte> piece) {
  if (load_->progress_.cancelled()) return load_cancelled();
  if (Status status = load_->upload_->append(piece); !status) {
    store_->note_error(status.error());
    return status;
  }
  load_->progress_.reach(load_->upload_->size());
  return success();
}

void IncomingScene::find_neighbours(NeighbourSource source) {
  load_->neighbours_.emplace(std::move(source), store_->folder_.get(),
                             load_->upload_->load_memory());
}

std::string tag_of(const std::string& sha256, const SceneChoice& choice) {
  return choice.scene ? sha256 + "-scene-" + std::to_string(*choice.scene) : sha256;
}

std::string with_neighbours(const std::string& tag, const std::string& neighbours) {
  return neighbours.empty() ? tag : tag + "-" + neighbours;
}

std::string unchanged_tag_of(const SceneRecord& record) {
  return with_neighbours(tag_of(record.sha256, {record.scene}), tag_of(record.neighbours));
}

StoredScene stored_scene_of(const SceneRecord& record) {
  StoredScene scene;
  scene.id = record.id;
  scene.revision = record.revision;
  scene.sha256 = record.sha256;
  scene.etag = with_neighbours(unchanged_tag_of(record), tag_of(record.changes));
  scene.chosen = record.scene;
  scene.changes = record.changes;
  scene.bytes = record.bytes;
  scene.persistent = true;
  return scene;
}

Error load_cancelled() {
  return {ErrorKind::kConflict, "LOAD_CANCELLED", "the scene was removed while it was loading", ""};
}

}  // namespace sightline
