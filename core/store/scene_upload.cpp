#include "core/store/scene_upload.h"

#include <algorithm>
#include <exception>

namespace sightline {

Error memory_full() {
  return {ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left for the scene", ""};
}

Status SceneUpload::append(std::span<const std::byte> piece) {
  if (file_) {
    if (Status status = write_all(file_->file(), piece, "store the scene"); !status) return status;
  } else {
    if (Status status = make_room(piece.size()); !status) return status;
    memory_.insert(memory_.end(), piece.begin(), piece.end());
  }
  size_ += piece.size();
  hash_.update(piece);
  return success();
}

Status SceneUpload::make_room(std::size_t bytes) {
  const std::size_t before = memory_.capacity(), wanted = memory_.size() + bytes;
  if (wanted <= before) return success();
  const std::size_t after = std::max(wanted, before + before / 2);
  // Until they are copied both are there.
  if (!shared_->take(after, before)) {
    return Error{ErrorKind::kBusy, "MEMORY_BUSY",
                 "scenes that are on their way use all the memory that they may: try again later",
                 ""};
  }
  try {
    memory_.reserve(after);
  } catch (const std::exception&) {
    shared_->give(after);
    return memory_full();
  }
  shared_->give(before);
  return success();
}

void SceneUpload::forget_memory() {
  if (memory_.capacity() == 0) return;
  shared_->give(memory_.capacity());
  std::vector<std::byte>().swap(memory_);
}

bool UploadMemory::take(std::uint64_t bytes, std::uint64_t own) {
  std::uint64_t taken = taken_.load();
  do {
    if (taken != own && (taken > limit_ || bytes > limit_ - taken)) return false;
  } while (!taken_.compare_exchange_weak(taken, taken + bytes));
  return true;
}

Result<SceneUpload> begin_upload(SceneFolder* folder, std::shared_ptr<UploadMemory> memory) {
  if (folder == nullptr) return SceneUpload(std::move(memory));
  auto file = folder->new_temporary();
  if (!file) return std::move(file).error();
  return SceneUpload(std::move(*file));
}

}  // namespace sightline
