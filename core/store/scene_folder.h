#pragma once
/// The data folder: scenes on disk, which survive a restart.
///
///   DIR/format            "sightline-store 2"; records of format 1 may lack a checksum
///   DIR/revision          the last number that a content was given (revision_counter.h)
///   DIR/lock              held while a server uses the folder
///   DIR/blobs/<sha256>    the bytes of a scene, named by their content
///   DIR/scenes/<id>.json  which bytes the scene of that name has: the commit point
///   DIR/trees/            what was built of them (tree_folder.h); removed with the bytes
///   DIR/tmp/<number>      what is being written; removed at start
///   DIR/quarantine/       what was found damaged, for a person to examine
///
/// Bytes that a record in quarantine names stay in blobs/ as long as that record is there, because
/// a person may be able to repair the scene. Nothing in quarantine is ever removed.
///
/// A scene is replaced by renaming one small record over another, after its bytes are on the disk.
/// So each record names complete bytes, whenever the machine stops.

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

/// Whether what lies on the disk is wrong, and not only out of reach.
bool is_damage(const Error& error);
/// What is said of damage besides, by how moving it came off.
std::string quarantine_note(const Status& moved);

/// May be used from many threads.
class SceneFolder {
 public:
  /// Makes the folder if there is none, and brings one of format 1 to format 2. A folder where that
  /// fails, as on a full disk, stays at format 1 and is used so. Errors: STORE_FOREIGN (there is
  /// something in it, but no `format` of a store: then nothing was changed), STORE_IN_USE (another
  /// process holds it), STORE_FORMAT_UNKNOWN (a newer version wrote it), those of io_error.
  static Result<std::unique_ptr<SceneFolder>> open(const std::filesystem::path& folder);

  struct Unread {
    std::string id;
    Error error;  ///< STORE_DAMAGED: the record is in quarantine now; else it stays where it is
  };
  struct Catalogue {
    std::vector<SceneRecord> records;
    std::vector<Unread> unread;
  };
  /// Reads all records, and drops bytes that no record names, be it here or in quarantine. Call
  /// once, before anything else. Errors: those of io_error, when it is not known which records
  /// there are.
  Result<Catalogue> read_catalogue();

  Result<TemporaryFile> new_temporary();
  /// Makes `bytes` and the neighbours (already synced, in the order of the record) the content of
  /// the scene, durably, and returns when it is. The bytes that the scene had before are dropped
  /// once no record names them. Errors: those of io_error; then the old record still stands, unless
  /// what failed was to make the new one durable: it stands if the machine lives on.
  Status commit(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
                const SceneRecord& record);
  /// Says something else of the bytes that the scene has, durably. Errors: as commit;
  /// CHANGES_TOO_MANY. Precondition: `record` names the bytes of the present one.
  Status amend(const SceneRecord& record);
  /// What is known of a scene. Errors: STORE_DAMAGED, those of io_error.
  Result<SceneRecord> read_record(const std::string& id) const;
  /// Forgets the scene, durably. No such record is no error.
  Status remove(const std::string& id);
  /// The bytes that have this hash. Errors: STORE_DAMAGED when they are missing, have another size
  /// or another hash; those of io_error, which say nothing about the bytes.
  Result<FileBytes> read_bytes(const std::string& sha256, std::uint64_t bytes,
                               std::optional<std::uint64_t> fingerprint = {});
  /// One of the files that a record names.
  struct File {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  /// Moves the record into quarantine, and `damaged`, the damaged file among those that it names.
  /// Its other files stay, because other scenes may use them. Reads the file again first, when
  /// nobody can replace it. If another scene has restored the right bytes meanwhile, moves nothing
  /// and returns false. Errors: those of io_error; what could not be moved then stays where it is.
  Result<bool> quarantine(const SceneRecord& record, const File& damaged);

 private:
  explicit SceneFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Status prepare();
  /// The number of the folder's format; 0 for an empty folder. Changes nothing. Errors:
  /// STORE_FOREIGN, STORE_FORMAT_UNKNOWN, those of io_error.
  Result<int> read_format() const;
  Status write_format() const;
  /// Gives every record a checksum, then writes the format. Records that are damaged stay as they
  /// are. Errors: those of io_error, also where a record cannot be read; then the format is 1
  /// still.
  Status upgrade();
  std::filesystem::path record_path(const std::string& id) const;
  std::filesystem::path blob_path(const std::string& sha256) const;
  Status quarantine_file(const std::filesystem::path& file) const;
  /// Replaces the previous record. Precondition: mutex_ is held.
  Status place_record(const SceneRecord& record, TemporaryFile& text, bool& stands) const;
  /// The renames of a commit. `stands` says whether a record that names the bytes may be on disk.
  Status place(TemporaryFile& bytes, std::span<TemporaryFile* const> neighbours,
               const SceneRecord& record, TemporaryFile& text, bool& stands) const;
  // Precondition for these: mutex_ is held. Retains the files that records in quarantine name, or
  // all files if a record cannot be understood.
  void hold_quarantined();
  void hold(const std::vector<std::string>& hashes);
  /// Drops bytes that nothing holds any more.
  void release(const std::vector<std::string>& hashes);
  void drop_reference(const std::string& id);

  std::filesystem::path folder_;
  FileDescriptor lock_;
  RecordForm form_ = RecordForm::kChecked;  ///< of the records in scenes/
  std::mutex mutex_;                        ///< orders commits and removals
  /// Which bytes each id has, as the records on disk say.
  std::map<std::string, std::vector<std::string>> references_;
  /// How many times each of them is named, by records (those in quarantine as well) and commits
  /// under way.
  std::unordered_map<std::string, std::size_t> holders_;
  /// Some records, here or in quarantine, could not be read, so the files that they name are
  /// unknown.
  bool keeps_all_ = false;
  std::uint64_t next_temporary_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
