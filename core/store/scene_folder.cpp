#include "core/store/scene_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/store/revision_counter.h"
#include "core/store/scene_id.h"
#include "core/store/sha256.h"
#include "core/store/tree_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFormatFamily = "sightline-store ";
constexpr std::string_view kFormat = "sightline-store 2\n";
constexpr std::string_view kOldFormat = "sightline-store 1\n";
constexpr const char* kFormatName = "format";
constexpr const char* kNewFormatName = "format.new";
constexpr const char* kLockName = "lock";
constexpr std::string_view kRecordSuffix = ".json";

/// Files of one name in quarantine.
constexpr int kMostQuarantined = 1000;

constexpr const char* kStoring = "store the scene";
constexpr const char* kDamaged = "STORE_DAMAGED";

Error damaged(std::string reason) {
  return {ErrorKind::kInternal, kDamaged, std::move(reason), ""};
}

std::vector<std::string> hashes_of(const SceneRecord& record) {
  std::vector<std::string> hashes{record.sha256};
  for (const NeighbourRecord& each : record.neighbours) hashes.push_back(each.sha256);
  return hashes;
}

/// As SceneFolder::new_temporary names its files.
bool is_temporary_name(std::string_view name) {
  return !name.empty() && name.size() <= 20 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool is_damage(const Error& error) { return error.code == kDamaged; }

std::string quarantine_note(const Status& moved) {
  return moved ? "; it was moved to quarantine" : "; " + moved.error().message;
}

fs::path SceneFolder::record_path(const std::string& id) const {
  return folder_ / "scenes" / (id + std::string(kRecordSuffix));
}

fs::path SceneFolder::blob_path(const std::string& sha256) const {
  return folder_ / "blobs" / sha256;
}

Status SceneFolder::sync(const FileDescriptor& file, const char* doing) const {
  return durability_ == Durability::kEverything ? sync_file(file, doing) : success();
}

Status SceneFolder::sync_names(const fs::path& folder, const char* doing) const {
  return durability_ == Durability::kEverything ? sync_folder(folder, doing) : success();
}

Result<std::unique_ptr<SceneFolder>> SceneFolder::open(const fs::path& folder,
                                                       Durability durability) {
  std::unique_ptr<SceneFolder> opened(new SceneFolder(folder, durability));
  if (Status status = opened->prepare(); !status) return std::move(status).error();
  return opened;
}

Result<int> SceneFolder::read_format() const {
  constexpr const char* kDoing = "open the data folder";
  // A folder of somebody else may be full of names that the store uses too: nothing in it is
  // touched before it is known to be the store's.
  const Error foreign{ErrorKind::kConflict, "STORE_FOREIGN",
                      "the data folder is not empty and was not made by this server: choose an "
                      "empty or a new folder",
                      ""};
  const auto files = list_folder(folder_, kDoing);
  if (!files) return files.error();
  bool others = false;
  for (const fs::path& file : *files) {
    const std::string name = file.filename().string();
    // What a first start leaves that is cut off before it writes its format; and a file system's.
    others |= name != kLockName && name != kNewFormatName && name != "lost+found";
  }
  // After the listing: another server may be making the folder at this moment.
  std::error_code error;
  const fs::path format = folder_ / kFormatName;
  if (!fs::exists(format, error)) {
    if (error) return io_error(kDoing, error.value());
    if (others) return foreign;
    return 0;
  }
  if (!fs::is_regular_file(format, error)) return foreign;
  const auto text = read_small_file(format, 256, kDoing);
  if (!text && !is_damage(text.error())) return text.error();
  if (!text || !text->starts_with(kFormatFamily)) return foreign;
  if (*text == kFormat) return 2;
  if (*text == kOldFormat) return 1;
  return Error{ErrorKind::kUnsupported, "STORE_FORMAT_UNKNOWN",
               "the data folder was written by another version of the store", ""};
}

Status SceneFolder::write_format() const {
  constexpr const char* kDoing = "write the format of the data folder";
  auto temporary = make_temporary(folder_ / kNewFormatName, kDoing);
  if (!temporary) return std::move(temporary).error();
  return write_durably(*temporary, kFormat, folder_ / kFormatName, kDoing);
}

Status SceneFolder::prepare() {
  constexpr const char* kDoing = "open the data folder";
  if (Status made = make_folder(folder_, "make the data folder"); !made) return made;
  if (auto format = read_format(); !format) return std::move(format).error();

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
  auto format = read_format();
  if (!format) return std::move(format).error();
  if (*format == 0) {
    if (Status status = write_format(); !status) return status;
  }
  for (const char* name : {"blobs", "scenes", "tmp", "quarantine"}) {
    if (Status made = make_folder(folder_ / name, "make the data folder"); !made) return made;
  }

  // What was half written when the last process ended is nobody's.
  const auto left = list_folder(folder_ / "tmp", kDoing);
  if (!left) return left.error();
  std::error_code error;
  for (const fs::path& file : *left) {
    if (!is_temporary_name(file.filename().string())) continue;
    if (fs::symlink_status(file, error).type() == fs::file_type::regular) fs::remove(file, error);
  }
  // A start needs no room: a folder that cannot be upgraded now is served as it is.
  if (*format == 1 && !upgrade()) form_ = RecordForm::kAny;
  return success();
}

Status SceneFolder::upgrade() {
  constexpr const char* kDoing = "upgrade a scene's record";
  const auto files = list_folder(folder_ / "scenes", kDoing);
  if (!files) return files.error();
  for (const fs::path& file : *files) {
    const std::string id = file.stem().string();
    if (file.extension() != kRecordSuffix || !is_scene_id(id)) continue;
    const auto text = read_small_file(file, kRecordLimit, kDoing);
    if (!text && !is_damage(text.error())) return text.error();
    const auto record = text ? decode_record(*text, id, RecordForm::kAny) : std::nullopt;
    if (!record) continue;
    auto temporary = new_temporary();
    if (!temporary) return std::move(temporary).error();
    Status status = fill_durably(*temporary, encode_record(*record), kDoing);
    if (!status) return status;
    status = rename_file(temporary->path(), file, kDoing);
    if (!status) return status;
    temporary->release();
  }
  if (Status status = sync_folder(folder_ / "scenes", kDoing); !status) return status;
  return write_format();
}

Result<SceneFolder::Catalogue> SceneFolder::read_catalogue() {
  constexpr const char* kDoing = "read a scene's record";
  const std::lock_guard hold_mutex(mutex_);
  auto files = list_folder(folder_ / "scenes", "list the scenes of the data folder");
  if (!files) return std::move(files).error();
  std::sort(files->begin(), files->end());
  Catalogue catalogue;
  for (const fs::path& file : *files) {
    const std::string id = file.stem().string();
    if (file.extension() != kRecordSuffix || !is_scene_id(id)) continue;
    const auto text = read_small_file(file, kRecordLimit, kDoing);
    auto record = text.ok() ? decode_record(*text, id, form_) : std::nullopt;
    if (record) {
      std::vector<std::string> hashes = hashes_of(*record);
      hold(hashes);
      references_[id] = std::move(hashes);
      catalogue.records.push_back(std::move(*record));
      continue;
    }
    Error error = text.ok() ? damaged("the scene's record is damaged") : text.error();
    if (durability_ == Durability::kRecords && is_damage(error)) {
      std::error_code left;
      if (fs::remove(file, left)) continue;
    }
    if (is_damage(error)) error.message += quarantine_note(quarantine_file(file));
    keeps_all_ = true;
    catalogue.unread.push_back({id, std::move(error)});
  }
  hold_quarantined();

  std::error_code error;
  for (const char* left : {"writing", "fetching"}) fs::remove(folder_ / "trees" / left, error);
  // Bytes without a record: a crash between the two steps of a commit, or of a removal. Not while a
  // record is damaged: it may name them. What cannot be listed stays as well.
  if (keeps_all_) return catalogue;
  const auto drop_strays = [&](const char* folder, auto owner_of) {
    const auto found = list_folder(folder_ / folder, "list the data folder");
    if (!found) return;
    for (const fs::path& file : *found) {
      const std::string owner = owner_of(file);
      if (!owner.empty() && !holders_.contains(owner)) fs::remove(file, error);
    }
  };
  drop_strays("blobs", [](const fs::path& file) {
    const std::string name = file.filename().string();
    return is_sha256(name) ? name : std::string();
  });
  drop_strays("trees", TreeFolder::owner_of);
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
  // The slow part, before anybody has to wait.
  if (Status status = sync(bytes.file(), kStoring); !status) return status;
  const std::string encoded = encode_record(record);
  if (encoded.size() > kRecordLimit) {
    return Error{ErrorKind::kTooLarge, "NEIGHBOURS_TOO_MANY",
                 "the names of the scene's other files are too many or too long", ""};
  }
  auto text = new_temporary();
  if (!text) return std::move(text).error();
  if (Status status = fill_durably(*text, encoded, kStoring); !status) return status;
  std::vector<std::string> hashes = hashes_of(record);

  const std::lock_guard hold_mutex(mutex_);
  std::vector<std::string>& named = references_[record.id];
  hold(hashes);
  bool stands = false;
  Status status = place(bytes, neighbours, record, *text, stands);
  // A record that stands in spite of an error, and the previous record: both may be what is found
  // at the next start, so the bytes of both stay until then.
  if (status) std::swap(named, hashes);
  if (status || !stands) release(hashes);
  return status;
}

Status SceneFolder::place(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
                          const SceneRecord& record, TemporaryFile& text, bool& stands) const {
  const auto move = [](TemporaryFile& file, const fs::path& to) {
    Status status = rename_file(file.path(), to, kStoring);
    if (status) file.release();
    return status;
  };
  const fs::path blob = blob_path(record.sha256);
  if (Status status = move(bytes, blob); !status) return status;
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    Status status = move(*neighbours[i], blob_path(record.neighbours[i].sha256));
    if (!status) return status;
  }
  if (Status status = sync_names(blob.parent_path(), kStoring); !status) return status;
  return place_record(record, text, stands);
}

Status SceneFolder::place_record(const SceneRecord& record, TemporaryFile& text,
                                 bool& stands) const {
  const fs::path target = record_path(record.id);
  if (Status status = rename_file(text.path(), target, kStoring); !status) return status;
  text.release();
  stands = true;
  return sync_names(target.parent_path(), kStoring);
}

Status SceneFolder::amend(const SceneRecord& record) {
  const std::string encoded = encode_record(record);
  if (encoded.size() > kRecordLimit) {
    return Error{ErrorKind::kTooLarge, "CHANGES_TOO_MANY",
                 "the changes of the scene's nodes take too much: send the file anew", ""};
  }
  auto text = new_temporary();
  if (!text) return std::move(text).error();
  if (Status status = fill_durably(*text, encoded, kStoring); !status) return status;
  const std::lock_guard hold_mutex(mutex_);
  bool stands = false;
  return place_record(record, *text, stands);
}

Result<SceneRecord> SceneFolder::read_record(const std::string& id, RecordPart part) const {
  const auto text = read_small_file(record_path(id), kRecordLimit, "read a scene's record");
  if (!text) return text.error();
  auto record = decode_record(*text, id, form_, part);
  if (!record) return damaged("the scene's record is damaged");
  return *std::move(record);
}

Status SceneFolder::remove(const std::string& id) {
  const std::lock_guard hold(mutex_);
  return remove_record(id, "remove the scene");
}

Status SceneFolder::remove_record(const std::string& id, const char* doing) {
  if (::unlink(record_path(id).c_str()) != 0 && errno != ENOENT) return io_error(doing, errno);
  if (Status status = sync_names(folder_ / "scenes", doing); !status) return status;
  drop_reference(id);
  return success();
}

Result<FileBytes> SceneFolder::read_bytes(const std::string& sha256, std::uint64_t bytes,
                                          std::optional<std::uint64_t> fingerprint,
                                          const OverflowFor& overflow_for) {
  const fs::path blob = blob_path(sha256);
  std::error_code error;
  if (!fs::exists(blob, error) && !error) return damaged("the scene's file is missing");
  auto file = open_file(blob, O_RDONLY, "read the scene's bytes");
  if (!file) return std::move(file).error();
  std::uint64_t found = 0;
  auto read = FileBytes::read(*file, "read the scene's bytes", found, overflow_for);
  if (!read) return read;
  if (read->bytes().size() != bytes) {
    return damaged("the scene's file has " + std::to_string(read->bytes().size()) +
                   " bytes, its record says " + std::to_string(bytes));
  }
  // The fingerprint may be what is damaged, or another version's: it can only spare the SHA-256.
  const bool is_known = fingerprint && found == *fingerprint;
  if (!is_known && sha256_of(read->bytes()) != sha256) {
    return damaged("the bytes of the scene's file changed: their hash is another one");
  }
  return read;
}

Result<bool> SceneFolder::quarantine(const SceneRecord& record, const File& damaged) {
  const std::lock_guard hold(mutex_);
  const auto again = read_bytes(damaged.sha256, damaged.bytes);
  if (again) return false;
  // What cannot be read now may be the right bytes.
  if (!is_damage(again.error())) return again.error();
  if (durability_ == Durability::kRecords) {
    Status removed = remove_record(record.id, "remove a damaged scene from the cache");
    if (!removed) return std::move(removed).error();
    return true;
  }
  Status moved = quarantine_file(record_path(record.id));
  if (!moved) return std::move(moved).error();
  // What the record names stays held, as hold_quarantined would hold it.
  references_.erase(record.id);
  moved = quarantine_file(blob_path(damaged.sha256));
  if (!moved) return std::move(moved).error();
  return true;
}

Status SceneFolder::quarantine_file(const fs::path& file) const {
  constexpr const char* kDoing = "move it to quarantine";
  std::error_code error;
  if (!fs::exists(file, error) && !error) return success();  // what is missing is damage too
  // Never over an earlier find: each has a number of its own.
  for (int number = 0; number < kMostQuarantined; ++number) {
    const fs::path target =
        folder_ / "quarantine" / (file.filename().string() + "." + std::to_string(number));
    if (fs::exists(target, error)) continue;
    return rename_file(file, target, kDoing);
  }
  return io_error(kDoing, EEXIST);
}

void SceneFolder::hold_quarantined() {
  constexpr const char* kDoing = "list the quarantine of the data folder";
  const auto files = list_folder(folder_ / "quarantine", kDoing);
  if (!files) keeps_all_ = true;
  for (const fs::path& file : files ? *files : std::vector<fs::path>()) {
    // "<id>.json.<number>", as quarantine_file names it.
    const fs::path named = file.stem();
    if (named.extension() != kRecordSuffix) continue;
    const auto text = read_small_file(file, kRecordLimit, kDoing);
    const auto record =
        text ? decode_record(*text, named.stem().string(), RecordForm::kAny) : std::nullopt;
    if (record) {
      hold(hashes_of(*record));
    } else {
      keeps_all_ = true;
    }
  }
}

void SceneFolder::hold(const std::vector<std::string>& hashes) {
  for (const std::string& hash : hashes) ++holders_[hash];
}

void SceneFolder::release(const std::vector<std::string>& hashes) {
  for (const std::string& hash : hashes) {
    const auto found = holders_.find(hash);
    if (found == holders_.end() || --found->second > 0) continue;
    holders_.erase(found);
    if (keeps_all_) continue;
    ::unlink(blob_path(hash).c_str());
    TreeFolder::forget(folder_ / "trees", hash);
  }
}

void SceneFolder::drop_reference(const std::string& id) {
  const auto found = references_.find(id);
  if (found == references_.end()) return;
  const std::vector<std::string> before = std::move(found->second);
  references_.erase(found);
  release(before);
}

}  // namespace sightline
