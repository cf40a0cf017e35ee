#pragma once
/// Neighbours of a scene's file: the files beside it that it refers to.

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/store/file_bytes.h"
#include "core/store/scene_folder.h"
#include "core/store/scene_upload.h"

namespace sightline {

/// Passes the bytes of the neighbour `name` to `sink`, in pieces. Returns the errors of the source
/// and of `sink`; the source decides which files may be read.
using NeighbourSource = std::function<Status(
    const std::string& name, const std::function<Status(std::span<const std::byte>)>& sink)>;

/// A tag of a list of neighbours; equal only if all their names and bytes are. Empty if there are
/// none.
std::string tag_of(const std::vector<NeighbourRecord>& neighbours);

/// Copies each neighbour when it is first requested. The copy is both loaded and stored, so that
/// later changes of the original files have no effect.
class CopiedNeighbours {
 public:
  /// Copies go into temporary files of `folder`, or into `memory` if it is null.
  CopiedNeighbours(NeighbourSource source, SceneFolder* folder,
                   std::shared_ptr<UploadMemory> memory)
      : source_(std::move(source)), folder_(folder), memory_(std::move(memory)) {}

  /// Returns the bytes of a neighbour, valid as long as this object. Errors: those of the source,
  /// NEIGHBOURS_TOO_MANY, those of SceneUpload.
  Result<std::span<const std::byte>> find(const std::string& name);
  std::vector<NeighbourRecord> records() const;
  /// The temporary files of the copies, in the order of records(); empty if copies are in memory.
  std::vector<TemporaryFile*> files();

 private:
  struct Copy {
    NeighbourRecord record;
    SceneUpload upload;
    std::optional<FileBytes> read;
  };
  NeighbourSource source_;
  SceneFolder* folder_;
  std::shared_ptr<UploadMemory> memory_;
  std::deque<Copy> copies_;
};

/// The stored neighbours of a scene, read from the data folder and checked.
class StoredNeighbours {
 public:
  /// Reads all neighbours that a record names. Sets `failed` to the file that an error is about.
  /// Errors: those of SceneFolder::read_bytes.
  static Result<StoredNeighbours> read(SceneFolder& folder, const SceneRecord& record,
                                       SceneFolder::File& failed);
  /// Returns the bytes of a neighbour, valid as long as this object. Errors: SOURCE_NOT_FOUND.
  Result<std::span<const std::byte>> find(const std::string& name) const;

 private:
  std::vector<std::pair<std::string, FileBytes>> files_;
};

/// The files that a record names.
struct RecordFiles {
  std::shared_ptr<const FileBytes> bytes;
  StoredNeighbours neighbours;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
