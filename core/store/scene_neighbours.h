#pragma once
/// The files beside a scene's file that its load asked for.

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

/// Hands the bytes of the neighbour on, in pieces. Whatever it says of them is the place where they
/// come from to decide.
using NeighbourSource = std::function<Status(
    const std::string& name, const std::function<Status(std::span<const std::byte>)>& sink)>;

/// Equal only where all of them are; empty where there are none.
std::string tag_of(const std::vector<NeighbourRecord>& neighbours);

/// Copies each neighbour when it is first requested. The copy is both loaded and stored, so later
/// changes of the files have no effect.
class CopiedNeighbours {
 public:
  /// `folder` may be null: then the copies are in `memory`.
  CopiedNeighbours(NeighbourSource source, SceneFolder* folder,
                   std::shared_ptr<UploadMemory> memory)
      : source_(std::move(source)), folder_(folder), memory_(std::move(memory)) {}

  /// Valid as long as this object. Errors: those of the source, NEIGHBOURS_TOO_MANY, those
  /// of SceneUpload.
  Result<std::span<const std::byte>> find(const std::string& name);
  std::vector<NeighbourRecord> records() const;
  /// The copies on disk, in the order of records(); none in memory.
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

/// Those that a record names, whole and checked.
class StoredNeighbours {
 public:
  /// failed  the record that an error is about
  /// Errors: those of SceneFolder::read_bytes.
  static Result<StoredNeighbours> read(SceneFolder& folder, const SceneRecord& record,
                                       SceneFolder::File& failed);
  /// Errors: SOURCE_NOT_FOUND.
  Result<std::span<const std::byte>> find(const std::string& name) const;

 private:
  std::vector<std::pair<std::string, FileBytes>> files_;
};

/// What a record names.
struct RecordFiles {
  std::shared_ptr<const FileBytes> bytes;
  StoredNeighbours neighbours;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
