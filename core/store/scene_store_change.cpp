/// How a store changes the nodes of a scene that it has.

#include "core/base/free_memory.h"
#include "core/store/scene_id.h"
#include "core/store/scene_store.h"

namespace sightline {
namespace {

/// How long a change waits for a content that another server has made.
constexpr std::chrono::seconds kMostWait{60};

Status check_changeable(const SceneSnapshot& scene, const Precondition& precondition) {
  if (!scene) return scene_not_found();
  if (scene->state == SceneState::kFailed) {
    return Error{ErrorKind::kConflict, "SCENE_FAILED", "the scene could not be loaded", ""};
  }
  if (!scene->scene) {
    return Error{ErrorKind::kConflict, "SCENE_LOADING", "the scene is still loading", ""};
  }
  return precondition.check(scene->etag);
}

/// The ETag that the content has without changes.
std::string unchanged_tag_of(const StoredScene& scene) {
  const std::string tag = tag_of(scene.changes);
  return tag.empty() ? scene.etag : scene.etag.substr(0, scene.etag.size() - tag.size() - 1);
}

}  // namespace

Result<SceneSnapshot> SceneStore::change(const std::string& id, const SceneChange& change,
                                         const Precondition& precondition) {
  const std::lock_guard one_by_one(change_mutex_);
  for (;;) {
    if (options_.shared.origin && is_scene_id(id)) {
      // A change builds on the newest content, by whichever client.
      const auto newest = catch_up(id, 0, Deadline::in(kMostWait));
      if (!newest) return newest.error();
    }
    const SceneSnapshot before = find(id);
    if (Status status = check_changeable(before, precondition); !status)
      return std::move(status).error();
    const auto changes = resolve(before->scene->description(), change);
    if (!changes) return changes.error();
    auto scene = before->scene->changed(changes->nodes, changes->sampled);
    if (!scene) return std::move(scene).error();
    StoredScene next = *before;
    next.scene = giving_back_memory(std::move(*scene), next.bytes);
    next.changes = with_changes(next.changes, changes->nodes);
    forget_removed(next.scene->description(), next.changes);
    next.etag = with_neighbours(unchanged_tag_of(*before), tag_of(next.changes));
    if (options_.admit) {
      if (Status status = options_.admit(next.scene); !status) return std::move(status).error();
    }
    const auto done = commit_change(before, next);
    if (!done) return done.error();
    // Else a load came in between: what it brought is changed.
    if (*done) return SceneSnapshot(std::make_shared<const StoredScene>(std::move(next)));
  }
}

Result<bool> SceneStore::commit_change(const SceneSnapshot& before, StoredScene& next) {
  const std::lock_guard commit(commit_mutex_);
  const auto present = [&]() -> Entry* {
    const auto found = entries_.find(next.id);
    const bool same = found != entries_.end() && found->second.content->scene == before->scene;
    return same ? &found->second : nullptr;
  };
  {
    const std::lock_guard hold(mutex_);
    if (present() == nullptr) return false;
  }
  const bool is_shared = options_.shared.origin && next.persistent;
  if (is_shared) {
    next.revision = before->revision + 1;
  } else {
    const auto revision = revisions_.next();
    if (!revision) return revision.error();
    next.revision = *revision;
  }
  if (folder_ && next.persistent) {
    auto record = folder_->read_record(next.id, RecordPart::kWithoutChanges);
    if (!record) return std::move(record).error();
    // A newer content of the origin is in the folder already, and is being loaded.
    if (is_shared && record->revision != before->revision) return false;
    // A put that failed at its last step: nobody was told that this content is there.
    if (unchanged_tag_of(*record) != unchanged_tag_of(*before)) {
      return Error{ErrorKind::kInternal, "STORE_IO",
                   "the scene's record on the disk is of another content: send the file again", ""};
    }
    record->revision = next.revision;
    record->changes = next.changes;
    if (is_shared) {
      const auto published = options_.shared.origin->publish(*record);
      if (!published) return published.error();
      if (!*published) return false;  // another server was first
    }
    if (Status status = folder_->amend(*record); !status) {
      note_error(status.error());
      return std::move(status).error();
    }
    failing_ = false;
  }
  const std::lock_guard hold(mutex_);
  // Loads that end and removals wait for commit_mutex_: what was there above is there now.
  Entry& entry = *present();
  next.update = entry.content->update;
  entry.content = std::make_shared<const StoredScene>(next);
  if (is_shared) stored_[next.id] = next.revision;
  note_change();
  return true;
}

}  // namespace sightline
