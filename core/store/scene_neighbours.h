#pragma once
/// Neighbours of a scene's file: the files beside it that it refers to.

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/store/file_bytes.h"
#include "core/store/scene_folder.h"
#include "core/store/scene_upload.h"

namespace sightline {

/// A function that passes the bytes of the neighbour `name` to `sink`, in pieces that are valid
/// during the call. It returns its own errors and those of `sink`. It decides which files may be
/// read.
using NeighbourSource = std::function<Status(
    const std::string& name, const std::function<Status(std::span<const std::byte>)>& sink)>;

/// A tag of a list of neighbours: a hash of their names and of the hashes of their bytes, in order.
/// Empty if there are none.
std::string tag_of(const std::vector<NeighbourRecord>& neighbours);

/// The neighbours of a scene that is being loaded. Copies each neighbour when it is first
/// requested. The copy is both loaded and stored, so that later changes of the original files have
/// no effect. Not thread-safe.
class CopiedNeighbours {
 public:
  /// Copies go into temporary files of `folder`, which must outlive the object. If `folder` is
  /// null, they go into `memory`, which is then not null.
  CopiedNeighbours(NeighbourSource source, SceneFolder* folder, std::shared_ptr<LoadMemory> memory)
      : source_(std::move(source)), folder_(folder), memory_(std::move(memory)) {}

  /// Returns the bytes of a neighbour, valid while this object lives and is not moved. Errors:
  /// those of the source, NEIGHBOURS_TOO_MANY (more than 4096), those of SceneUpload and io_error,
  /// HASH_FAILED. After an error the neighbour may be requested again.
  Result<std::span<const std::byte>> find(const std::string& name);
  /// The neighbours that were requested so far, in the order of the first requests.
  std::vector<NeighbourRecord> records() const;
  /// The temporary files of the copies, synced and closed, in the order of records(); valid while
  /// this object lives. Empty if copies are in memory.
  std::vector<TemporaryFile*> files();

 private:
  struct Copy {
    NeighbourRecord record;
    SceneUpload upload;
    std::optional<FileBytes> read;
  };
  NeighbourSource source_;
  SceneFolder* folder_;
  std::shared_ptr<LoadMemory> memory_;
  std::deque<Copy> copies_;
};

/// The stored neighbours of a scene, in memory and checked.
class StoredNeighbours {
 public:
  /// Reads all neighbours that a record names. Errors: those of SceneFolder::read_bytes; `failed`
  /// is then the file that could not be read, else it is unchanged.
  static Result<StoredNeighbours> read(SceneFolder& folder, const SceneRecord& record,
                                       SceneFolder::File& failed);
  /// Adds a neighbour, whose hash the caller has checked.
  void add(const std::string& name, FileBytes bytes) {
    files_.emplace_back(name, std::move(bytes));
  }
  /// Returns the bytes of a neighbour, valid while this object lives and is not moved. Errors:
  /// SOURCE_NOT_FOUND.
  Result<std::span<const std::byte>> find(const std::string& name) const;

 private:
  std::vector<std::pair<std::string, FileBytes>> files_;
};

/// The files that a record names, in memory; `bytes` is not null once they are read.
struct RecordFiles {
  std::shared_ptr<const FileBytes> bytes;
  StoredNeighbours neighbours;
};

/// The files that a record of an origin names, in memory.
struct FetchedFiles {
  RecordFiles files;
  /// Their copies: the scene's file, then its neighbours, closed, in the order of the record. Empty
  /// if the data folder has the files.
  std::vector<TemporaryFile> copies;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
