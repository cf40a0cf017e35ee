#include "core/store/tree_folder.h"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <system_error>
#include <vector>

#include "core/scene/tree_cache.h"
#include "core/store/file_bytes.h"
#include "core/store/temporary_file.h"

namespace sightline {

namespace {

constexpr const char* kStoringTrees = "keep a scene's trees";
constexpr const char* kSuffix = ".trees";

Error not_stored() { return {ErrorKind::kCancelled, "CANCELLED", "the trees were not stored", ""}; }

/// That are on the disk before the next are written: nobody can cancel a sync, and one of hundreds
/// of megabytes takes seconds.
constexpr std::size_t kWrittenAtOnce = 16 << 20;

Status write_in_pieces(const FileDescriptor& file, std::span<const std::byte> bytes,
                       const CancelFlag* cancel) {
  while (!bytes.empty()) {
    if (is_cancelled(cancel)) return not_stored();
    const auto piece = bytes.first(std::min(kWrittenAtOnce, bytes.size()));
    bytes = bytes.subspan(piece.size());
    if (Status status = write_all(file, piece, kStoringTrees); !status) return status;
    if (bytes.empty()) break;  // the end is synced with what follows
    if (Status status = sync_file(file, kStoringTrees); !status) return status;
  }
  return success();
}

}  // namespace

std::filesystem::path TreeFolder::path_of(std::uint64_t content, const std::string& sha256) const {
  char name[32];
  std::snprintf(name, sizeof name, "%016llx%s", static_cast<unsigned long long>(content), kSuffix);
  return folder_ / (sha256.empty() ? name : sha256 + "-" + name);
}

std::string TreeFolder::owner_of(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::size_t dash = name.find('-');
  return dash == std::string::npos ? "" : name.substr(0, dash);
}

void TreeFolder::forget(const std::filesystem::path& folder, const std::string& sha256) {
  std::error_code error;
  const auto files = list_folder(folder, kStoringTrees);
  if (!files) return;
  for (const std::filesystem::path& file : *files) {
    if (owner_of(file) == sha256) std::filesystem::remove(file, error);
  }
}

Result<std::optional<SceneTree>> TreeFolder::read(const ScenePlan& plan, std::uint64_t content,
                                                  const std::string& sha256) const {
  const std::filesystem::path path = path_of(content, sha256);
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(path, error)))
    return std::optional<SceneTree>();
  auto file = open_file(path, O_RDONLY | O_NOFOLLOW, kStoringTrees);
  if (!file) return std::move(file).error();
  auto read_file = FileBytes::read(*file, kStoringTrees);
  if (!read_file) return std::move(read_file).error();
  const auto owner = std::make_shared<const FileBytes>(std::move(*read_file));
  auto tree = decode_trees(plan, content, owner->bytes(), owner);
  if (!tree) {
    std::filesystem::remove(path, error);
    return std::move(tree).error();
  }
  // The time says when it was of use last.
  std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now(), error);
  return std::optional<SceneTree>(std::move(*tree));
}

Status TreeFolder::fetch(OriginScenes& origin, std::uint64_t content, const std::string& sha256,
                         const CancelFlag* cancel) const {
  const std::filesystem::path path = path_of(content, sha256);
  std::error_code error;
  if (std::filesystem::exists(path, error)) return success();
  std::filesystem::create_directories(folder_, error);
  if (error) return io_error(kStoringTrees, error.value());
  auto temporary = make_temporary(folder_ / "fetching", kStoringTrees);
  if (!temporary) return std::move(temporary).error();
  const auto found =
      origin.read_trees(path.filename().string(), [&](std::span<const std::byte> piece) -> Status {
        if (is_cancelled(cancel)) return not_stored();
        return write_all(temporary->file(), piece, kStoringTrees);
      });
  if (!found) return found.error();
  if (!*found) return success();
  if (Status status = sync_file(temporary->file(), kStoringTrees); !status) return status;
  make_room(std::filesystem::file_size(temporary->path(), error));
  if (Status status = rename_file(temporary->path(), path, kStoringTrees); !status) return status;
  temporary->release();
  return success();
}

Status TreeFolder::publish(OriginScenes& origin, std::uint64_t content,
                           const std::string& sha256) const {
  const std::filesystem::path path = path_of(content, sha256);
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  if (error) return success();  // it was too large to be stored, or went with its scene
  const auto file = open_file(path, O_RDONLY | O_NOFOLLOW, kStoringTrees);
  if (!file) return file.error();
  return origin.store_trees(path.filename().string(), *file, bytes);
}

void TreeFolder::make_room(std::uint64_t bytes) const {
  struct File {
    std::filesystem::file_time_type used;
    std::uint64_t bytes;
    std::filesystem::path path;
  };
  std::vector<File> files;
  std::uint64_t sum = bytes;
  std::error_code error;
  const auto found = list_folder(folder_, kStoringTrees);
  if (!found) return;
  for (const std::filesystem::path& path : *found) {
    if (path.extension() != kSuffix || !std::filesystem::is_regular_file(path, error)) continue;
    files.push_back({std::filesystem::last_write_time(path, error),
                     std::filesystem::file_size(path, error), path});
    sum += files.back().bytes;
  }
  std::sort(files.begin(), files.end(),
            [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (sum <= bytes_max_) break;
    std::filesystem::remove(file.path, error);
    sum -= file.bytes;
  }
}

Status TreeFolder::write(const SceneTree& tree, std::uint64_t content, const std::string& sha256,
                         const CancelFlag* cancel) const {
  const EncodedTrees encoded = encode_trees(tree, content);
  std::uint64_t bytes = encoded.head.size();
  for (const auto& arena : encoded.arenas) bytes += arena.size();
  if (bytes > bytes_max_) return success();
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) return io_error(kStoringTrees, error.value());
  make_room(bytes);
  // One writer at a time, by precondition: what a stopped run left under this name is replaced.
  auto temporary = make_temporary(folder_ / "writing", kStoringTrees);
  if (!temporary) return std::move(temporary).error();
  const FileDescriptor& file = temporary->file();
  if (Status status = write_all(file, encoded.head, kStoringTrees); !status) return status;
  for (const auto& arena : encoded.arenas) {
    if (Status status = write_in_pieces(file, arena, cancel); !status) return status;
  }
  if (Status status = sync_file(file, kStoringTrees); !status) return status;
  if (Status status = rename_file(temporary->path(), path_of(content, sha256), kStoringTrees);
      !status)
    return status;
  temporary->release();
  return sync_folder(folder_, kStoringTrees);
}

}  // namespace sightline
