#include "core/store/scene_upload.h"

#include <new>

namespace sightline {

Error memory_full() {
  return {ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left for the scene", ""};
}

Status SceneUpload::append(std::span<const std::byte> piece) {
  if (file_) {
    if (Status status = write_all(file_->file(), piece, "store the scene"); !status) return status;
  } else {
    try {
      memory_.insert(memory_.end(), piece.begin(), piece.end());
    } catch (const std::bad_alloc&) {
      return memory_full();
    }
  }
  size_ += piece.size();
  hash_.update(piece);
  return success();
}

Result<SceneUpload> begin_upload(SceneFolder* folder) {
  if (folder == nullptr) return SceneUpload();
  auto file = folder->new_temporary();
  if (!file) return std::move(file).error();
  return SceneUpload(std::move(*file));
}

}  // namespace sightline
