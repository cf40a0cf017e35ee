#include "core/store/scene_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/base/content_hash.h"
#include "core/store/revision_counter.h"
#include "core/store/scene_id.h"
#include "core/store/sha256.h"
#include "core/store/tree_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFormatFamily = "sightline-store ";
constexpr std::string_view kFormat = "sightline-store 1\n";
constexpr const char* kFormatName = "format";
constexpr const char* kNewFormatName = "format.new";
constexpr const char* kLockName = "lock";
constexpr std::string_view kRecordSuffix = ".json";

/// As SceneFolder::new_temporary names its files.
bool is_temporary_name(std::string_view name) {
  return !name.empty() && name.size() <= 20 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

fs::path SceneFolder::record_path(const std::string& id) const {
  return folder_ / "scenes" / (id + std::string(kRecordSuffix));
}

fs::path SceneFolder::blob_path(const std::string& sha256) const {
  return folder_ / "blobs" / sha256;
}

Result<std::unique_ptr<SceneFolder>> SceneFolder::open(const fs::path& folder) {
  std::unique_ptr<SceneFolder> opened(new SceneFolder(folder));
  if (Status status = opened->prepare(); !status) return std::move(status).error();
  return opened;
}

Result<bool> SceneFolder::has_format() const {
  constexpr const char* kDoing = "open the data folder";
  // A folder of somebody else may be full of names that the store uses too: nothing in it is
  // touched before it is known to be the store's.
  const Error foreign{ErrorKind::kConflict, "STORE_FOREIGN",
                      "the data folder is not empty and was not made by this server: choose an "
                      "empty or a new folder",
                      ""};
  std::error_code error;
  bool others = false;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    // What a first start leaves that is cut off before it writes its format; and a file system's.
    others |= name != kLockName && name != kNewFormatName && name != "lost+found";
  }
  if (error) return io_error(kDoing, error.value());
  // After the listing: another server may be making the folder at this moment.
  const fs::path format = folder_ / kFormatName;
  if (!fs::exists(format, error)) {
    if (error) return io_error(kDoing, error.value());
    if (others) return foreign;
    return false;
  }
  if (!fs::is_regular_file(format, error)) return foreign;
  const auto text = read_small_file(format, 256, kDoing);
  if (!text || !text->starts_with(kFormatFamily)) return foreign;
  if (*text != kFormat) {
    return Error{ErrorKind::kUnsupported, "STORE_FORMAT_UNKNOWN",
                 "the data folder was written by another version of the store", ""};
  }
  return true;
}

Status SceneFolder::prepare() {
  constexpr const char* kDoing = "open the data folder";
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return io_error("make the data folder", error.value());
  if (auto ours = has_format(); !ours) return std::move(ours).error();

  // One process at a time; the lock goes with the process, however it ends.
  auto lock = open_file(folder_ / kLockName, O_RDWR | O_CREAT, kDoing);
  if (!lock) return std::move(lock).error();
  lock_ = std::move(*lock);
  if (::flock(lock_.number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return io_error(kDoing, errno);
    return Error{ErrorKind::kConflict, "STORE_IN_USE",
                 "the data folder is in use by another server", ""};
  }

  // Again, now that no other server can change it.
  auto ours = has_format();
  if (!ours) return std::move(ours).error();
  if (!*ours) {
    auto temporary = make_temporary(folder_ / kNewFormatName, kDoing);
    if (!temporary) return std::move(temporary).error();
    if (Status status = write_durably(*temporary, kFormat, folder_ / kFormatName, kDoing);
        !status) {
      return status;
    }
  }
  for (const char* name : {"blobs", "scenes", "tmp", "quarantine"}) {
    fs::create_directories(folder_ / name, error);
    if (error) return io_error("make the data folder", error.value());
  }

  // What was half written when the last process ended is nobody's.
  for (const auto& entry : fs::directory_iterator(folder_ / "tmp", error)) {
    if (!is_temporary_name(entry.path().filename().string())) continue;
    if (entry.symlink_status(error).type() == fs::file_type::regular) {
      fs::remove(entry.path(), error);
    }
  }
  return success();
}

SceneFolder::Catalogue SceneFolder::read_catalogue() {
  const std::lock_guard hold(mutex_);
  Catalogue catalogue;
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder_ / "scenes", error)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const std::string id = file.stem().string();
    if (file.extension() != kRecordSuffix || !is_scene_id(id)) continue;
    const auto text = read_small_file(file, kRecordLimit, "read a scene's record");
    auto record = text.ok() ? decode_record(*text, id) : std::nullopt;
    if (!record) {
      quarantine_file(file);
      catalogue.damaged.push_back(
          {id, text.ok() ? "the scene's record is damaged" : text.error().message});
      continue;
    }
    set_reference(*record);
    catalogue.records.push_back(std::move(*record));
  }

  fs::remove(folder_ / "trees" / "writing", error);
  // Bytes without a record: a crash between the two steps of a commit, or of a removal. Not while
  // a record is damaged: it may be the one that named them.
  if (catalogue.damaged.empty()) {
    for (const auto& entry : fs::directory_iterator(folder_ / "blobs", error)) {
      const std::string name = entry.path().filename().string();
      if (is_sha256(name) && !has_record(name)) fs::remove(entry.path(), error);
    }
    for (const auto& entry : fs::directory_iterator(folder_ / "trees", error)) {
      const std::string owner = TreeFolder::owner_of(entry.path());
      if (!owner.empty() && !has_record(owner)) fs::remove(entry.path(), error);
    }
  }
  return catalogue;
}

Result<TemporaryFile> SceneFolder::new_temporary() {
  std::uint64_t number = 0;
  {
    const std::lock_guard hold(mutex_);
    number = next_temporary_++;
  }
  return make_temporary(folder_ / "tmp" / std::to_string(number), "write to the data folder");
}

Status SceneFolder::commit(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
                           const SceneRecord& record) {
  constexpr const char* kDoing = "store the scene";
  // The slow part, before anybody has to wait.
  if (Status status = sync_file(bytes.file(), kDoing); !status) return status;
  auto temporary = new_temporary();
  if (!temporary) return std::move(temporary).error();
  const std::string text = encode_record(record);
  if (text.size() > kRecordLimit) {
    return Error{ErrorKind::kTooLarge, "NEIGHBOURS_TOO_MANY",
                 "the names of the scene's other files are too many or too long", ""};
  }

  const std::lock_guard hold(mutex_);
  const fs::path blob = blob_path(record.sha256);
  if (Status status = rename_file(bytes.path(), blob, kDoing); !status) return status;
  bytes.release();
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const fs::path target = blob_path(record.neighbours[i].sha256);
    if (Status status = rename_file(neighbours[i]->path(), target, kDoing); !status) return status;
    neighbours[i]->release();
  }
  if (Status status = sync_folder(blob.parent_path(), kDoing); !status) return status;
  if (Status status = write_durably(*temporary, text, record_path(record.id), kDoing); !status) {
    return status;
  }
  set_reference(record);
  return success();
}

Status SceneFolder::remove(const std::string& id) {
  constexpr const char* kDoing = "remove the scene";
  const std::lock_guard hold(mutex_);
  if (::unlink(record_path(id).c_str()) != 0 && errno != ENOENT) return io_error(kDoing, errno);
  if (Status status = sync_folder(folder_ / "scenes", kDoing); !status) return status;
  drop_reference(id);
  return success();
}

Result<MappedFile> SceneFolder::map(const std::string& sha256, std::uint64_t bytes,
                                    std::optional<std::uint64_t> fingerprint) {
  const auto damaged = [](std::string reason) {
    return Error{ErrorKind::kInternal, "STORE_DAMAGED", std::move(reason), ""};
  };
  auto file = open_file(blob_path(sha256), O_RDONLY, "read the scene's bytes");
  if (!file) return damaged(file.error().message);
  auto mapped = MappedFile::map(*file, "read the scene's bytes");
  if (!mapped) return mapped;
  if (mapped->bytes().size() != bytes) {
    return damaged("the scene's file has " + std::to_string(mapped->bytes().size()) +
                   " bytes, its record says " + std::to_string(bytes));
  }
  // The fingerprint may be what is damaged, or another version's: it can only spare the SHA-256.
  const bool is_known = fingerprint && hash_in_pieces(mapped->bytes()) == *fingerprint;
  if (!is_known && sha256_of(mapped->bytes()) != sha256) {
    return damaged("the bytes of the scene's file changed: their hash is another one");
  }
  return mapped;
}

void SceneFolder::quarantine(const SceneRecord& record) {
  const std::lock_guard hold(mutex_);
  quarantine_file(record_path(record.id));
  quarantine_file(blob_path(record.sha256));
  drop_reference(record.id);
}

void SceneFolder::quarantine_file(const fs::path& file) {
  // Never over an earlier find: each keeps its own number.
  std::error_code error;
  for (int number = 0; number < 1000; ++number) {
    const fs::path target =
        folder_ / "quarantine" / (file.filename().string() + "." + std::to_string(number));
    if (fs::exists(target, error)) continue;
    fs::rename(file, target, error);
    return;
  }
}

void SceneFolder::set_reference(const SceneRecord& record) {
  std::vector<std::string> now{record.sha256};
  for (const NeighbourRecord& each : record.neighbours) now.push_back(each.sha256);
  std::swap(references_[record.id], now);
  for (const std::string& before : now) drop_bytes_without_record(before);
}

void SceneFolder::drop_reference(const std::string& id) {
  const auto found = references_.find(id);
  if (found == references_.end()) return;
  const std::vector<std::string> before = std::move(found->second);
  references_.erase(found);
  for (const std::string& each : before) drop_bytes_without_record(each);
}

bool SceneFolder::has_record(const std::string& sha256) const {
  return std::any_of(references_.begin(), references_.end(), [&](const auto& reference) {
    const auto& hashes = reference.second;
    return std::find(hashes.begin(), hashes.end(), sha256) != hashes.end();
  });
}

void SceneFolder::drop_bytes_without_record(const std::string& sha256) {
  if (has_record(sha256)) return;
  ::unlink(blob_path(sha256).c_str());
  TreeFolder::forget(folder_ / "trees", sha256);
}

}  // namespace sightline
