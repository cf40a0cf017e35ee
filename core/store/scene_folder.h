#pragma once
/// SceneFolder: the data folder with the scenes on disk, which survive a restart.
///
///   DIR/format            "sightline-store 2"; records of format 1 may lack a checksum
///   DIR/revision          the last number that was given to a content (revision_counter.h)
///   DIR/lock              locked while a server uses the folder
///   DIR/blobs/<sha256>    the bytes of a file, named by their SHA-256
///   DIR/scenes/<id>.json  the record of a scene: which bytes it has; writing it is the commit
///   DIR/trees/            trees that were built (tree_folder.h); removed with the bytes
///   DIR/tmp/<number>      files that are being written; removed at start
///   DIR/quarantine/       damaged files, for a person to examine
///
/// Bytes that a record in quarantine names stay in blobs/ as long as the record is there, because a
/// person may be able to repair the scene. The server never removes anything from quarantine.
///
/// A scene is replaced by renaming a new record over the old one, after its bytes are on the disk.
/// So each record names complete bytes at any moment at which the machine may stop.
///
/// In the cache of an origin a commit syncs the text of the record alone. A crash of the machine
/// may damage bytes there, or bring back a replaced or removed record. A read finds damaged bytes.
/// They are deleted, not moved to quarantine, because the origin has the right ones.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/base/result.h"
#include "core/store/file_bytes.h"
#include "core/store/posix_file.h"
#include "core/store/scene_record.h"
#include "core/store/temporary_file.h"

namespace sightline {

/// True if an error means that data on the disk is wrong; false if it is only inaccessible.
bool is_damage(const Error& error);
/// A note for the message of a damage error: whether the file was moved to quarantine. `moved` is
/// the result of the move.
std::string quarantine_note(const Status& moved);

/// What a crash of the machine must not damage.
enum class Durability {
  kEverything,
  kRecords,  ///< for a cache of an origin: the texts of records alone
};

/// The data folder of a running server: open(), read_catalogue() once, then the other functions.
/// The destructor unlocks the folder. Thread-safe.
class SceneFolder {
 public:
  /// Opens a data folder and locks it; makes the folder if there is none. A folder of format 1 is
  /// upgraded to format 2; if that fails, as on a full disk, it is used as format 1. Errors:
  /// STORE_FOREIGN (the folder is not empty and has no `format` file of a store; nothing was
  /// changed), STORE_IN_USE (another process has locked it), STORE_FORMAT_UNKNOWN (a newer version
  /// wrote it), those of io_error.
  static Result<std::unique_ptr<SceneFolder>> open(const std::filesystem::path& folder,
                                                   Durability durability = Durability::kEverything);

  /// A record that could not be read.
  struct Unread {
    std::string id;
    /// STORE_DAMAGED: the record is in quarantine now; other errors: it stays where it is
    Error error;
  };
  /// All scenes of the folder.
  struct Catalogue {
    std::vector<SceneRecord> records;
    std::vector<Unread> unread;
  };
  /// Reads all records. Deletes bytes that no record here or in quarantine names, if all records
  /// could be read. Must be called once, before the functions below. Errors: those of io_error if
  /// the list of records cannot be read.
  Result<Catalogue> read_catalogue();

  /// A new file in DIR/tmp. Errors: those of io_error.
  Result<TemporaryFile> new_temporary();
  /// Makes `bytes` and `neighbours` the content of the scene, durably with kEverything. They are
  /// renamed, so the objects no longer own a file after success. `neighbours` must be in the order
  /// of the record, and with kEverything synced. The previous bytes of the scene are deleted when
  /// no record names them. Errors: those of io_error, NEIGHBOURS_TOO_MANY (the record exceeds
  /// kRecordLimit). The old record then remains, except if only the last sync failed: then the new
  /// record is there unless the machine crashes.
  Status commit(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
                const SceneRecord& record);
  /// Replaces the record of a scene without changing its bytes, durably with kEverything. Errors:
  /// those of io_error, CHANGES_TOO_MANY (the record exceeds kRecordLimit); the record is then as
  /// after a failed commit. Precondition: `record` names the bytes of the present record.
  Status amend(const SceneRecord& record);
  /// Reads the record of a scene. Errors: STORE_DAMAGED, those of io_error.
  Result<SceneRecord> read_record(const std::string& id,
                                  RecordPart part = RecordPart::kWhole) const;
  /// Removes the record of a scene, durably with kEverything, then its bytes and trees if no other
  /// record names the bytes. It is no error if there is no scene. Errors: those of io_error. If the
  /// record could not be unlinked, nothing has changed; if only the sync failed, the bytes stay
  /// until the next start.
  Status remove(const std::string& id);
  /// Reads the file with this SHA-256 and `bytes` bytes, and checks it. If its hash_in_pieces
  /// equals `fingerprint`, the SHA-256 is not computed. Errors: STORE_DAMAGED if the bytes are
  /// missing or have another size or hash; OVERFLOW_FULL and those of io_error, which do not tell if
  /// the bytes are damaged.
  Result<FileBytes> read_bytes(const std::string& sha256, std::uint64_t bytes,
                               std::optional<std::uint64_t> fingerprint = {},
                               const OverflowFor& overflow_for = {});
  /// A file that a record names.
  struct File {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  /// Moves a record and `damaged`, a damaged file that it names, into quarantine; deletes them with
  /// kRecords. Other files of the record stay, because other scenes may use them. First reads the
  /// file again, to check that it is still damaged. If another scene has stored the right bytes
  /// meanwhile, moves nothing and returns false; otherwise returns true. Errors: those of io_error.
  /// A file that could not be moved stays where it is; the record may then be in quarantine without
  /// the file.
  Result<bool> quarantine(const SceneRecord& record, const File& damaged);

 private:
  SceneFolder(std::filesystem::path folder, Durability durability)
      : folder_(std::move(folder)), durability_(durability) {}
  /// Both do nothing with kRecords.
  Status sync(const FileDescriptor& file, const char* doing) const;
  Status sync_names(const std::filesystem::path& folder, const char* doing) const;
  Status prepare();
  /// Returns the number of the folder's format, 0 for an empty folder. Changes nothing. Errors:
  /// STORE_FOREIGN, STORE_FORMAT_UNKNOWN, those of io_error.
  Result<int> read_format() const;
  Status write_format() const;
  /// Upgrades to format 2: gives every record a checksum, then writes the format. Damaged records
  /// stay unchanged. Errors: those of io_error, also if a record cannot be read; the format then
  /// stays 1.
  Status upgrade();
  std::filesystem::path record_path(const std::string& id) const;
  std::filesystem::path blob_path(const std::string& sha256) const;
  Status quarantine_file(const std::filesystem::path& file) const;
  /// Replaces the record of a scene by the file `text`. Sets `stands` to true once the new record
  /// may be on disk. Precondition: mutex_ is held.
  Status place_record(const SceneRecord& record, TemporaryFile& text, bool& stands) const;
  /// Does the renames of a commit. `stands` is as for place_record.
  Status place(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
               const SceneRecord& record, TemporaryFile& text, bool& stands) const;
  // Preconditions: mutex_ is held. hold_quarantined retains the files that records in quarantine
  // name, or all files if a record cannot be decoded.
  void hold_quarantined();
  void hold(const std::vector<std::string>& hashes);
  /// Deletes bytes that no record or commit names any more.
  void release(const std::vector<std::string>& hashes);
  void drop_reference(const std::string& id);
  /// As remove().
  Status remove_record(const std::string& id, const char* doing);

  std::filesystem::path folder_;
  Durability durability_;
  FileDescriptor lock_;
  RecordForm form_ = RecordForm::kChecked;  ///< of the records in scenes/
  std::mutex mutex_;                        ///< orders commits and removals
  /// The hashes of the files of each scene, as in the records on disk.
  std::map<std::string, std::vector<std::string>> references_;
  /// How many records (those in quarantine included) and running commits name each hash.
  std::unordered_map<std::string, std::size_t> holders_;
  /// True if some records, here or in quarantine, could not be read. Their files are unknown, so no
  /// file is deleted.
  bool keeps_all_ = false;
  std::uint64_t next_temporary_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
