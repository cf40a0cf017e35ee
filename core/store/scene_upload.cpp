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
    std::copy(piece.begin(), piece.end(), memory_.get() + size_);
  }
  size_ += piece.size();
  hash_.update(piece);
  return success();
}

Status SceneUpload::make_room(std::size_t bytes) {
  const std::uint64_t wanted = size_ + bytes;
  if (wanted <= taken_) return success();
  const std::uint64_t after = whole_pages(std::max(wanted, taken_ + taken_ / 2));
  if (!shared_->take(after - taken_)) {
    return Error{ErrorKind::kBusy, "MEMORY_BUSY",
                 "scenes that are on their way use all the memory that they may: try again later",
                 ""};
  }
  try {
    enlarge(memory_, after);
  } catch (const std::exception&) {
    shared_->give(after - taken_);
    return memory_full();
  }
  taken_ = after;
  return success();
}

Result<FileBytes> SceneUpload::take_memory(const OverflowFor& overflow_for) {
  return FileBytes::adopt(std::move(memory_), size_, "load the scene", overflow_for);
}

void SceneUpload::forget_memory() {
  memory_.reset();
  if (shared_) shared_->give(std::exchange(taken_, 0));
}

bool UploadMemory::take(std::uint64_t bytes, std::uint64_t own) {
  std::uint64_t taken = taken_.load();
  do {
    if (taken != own && (taken > limit_ || bytes > limit_ - taken)) return false;
  } while (!taken_.compare_exchange_weak(taken, taken + bytes));
  return true;
}

Result<SceneUpload> begin_upload(SceneFolder* folder, std::shared_ptr<LoadMemory> memory) {
  if (folder == nullptr) return SceneUpload(std::move(memory));
  auto file = folder->new_temporary();
  if (!file) return std::move(file).error();
  return SceneUpload(std::move(*file));
}

}  // namespace sightline
