#pragma once
/// TreeFolder: files of trees between two runs (core/scene/tree_cache.h). They are only a cache:
/// trees whose file is missing, foreign, stale or damaged are built again.
///
///     DIR/<sha256>-<content>.trees   of a scene in a data folder; removed with the scene's bytes
///     DIR/<content>.trees            of any other scene
///     DIR/writing                    the file that is being written
///     DIR/fetching                   the file that is being copied from an origin

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/scene/scene_trees.h"
#include "core/store/origin_scenes.h"
#include "core/store/posix_file.h"

namespace sightline {

/// Reads and writes files of trees in one folder. read() may run on several threads at once.
class TreeFolder {
 public:
  /// The usual limit of all files.
  static constexpr std::uint64_t kUsualBytes = std::uint64_t{64} << 30;

  /// The folder is made when the first file is written. If the files exceed `bytes_max` in total,
  /// the least recently used are removed, here too.
  explicit TreeFolder(std::filesystem::path folder, std::uint64_t bytes_max = kUsualBytes)
      : folder_(std::move(folder)), bytes_max_(bytes_max) {
    make_room(0);
  }

  /// Reads the trees of a plan; empty if there is no file. `content` is the plan's content_hash,
  /// `sha256` the hash of the scene's file in the data folder or empty. The trees refer to the
  /// memory into which the file was read. Errors: those of io_error; those of
  /// decode_trees, after which the file is removed.
  Result<std::optional<SceneTree>> read(const ScenePlan& plan, std::uint64_t content,
                                        const std::string& sha256) const;
  /// Writes trees, durably; at any moment the file is either complete or absent. Writes nothing if
  /// they exceed bytes_max. Errors: those of io_error; CANCELLED soon after `cancel` is set.
  /// Precondition: one call at a time.
  Status write(const SceneTree& tree, std::uint64_t content, const std::string& sha256,
               const CancelFlag* cancel = nullptr) const;

  /// Copies a file of trees from an origin, unless the folder has it or the origin lacks it. Errors:
  /// those of Origin and of io_error; CANCELLED soon after `cancel` is set. Precondition: one call
  /// at a time.
  Status fetch(OriginScenes& origin, std::uint64_t content, const std::string& sha256,
               const CancelFlag* cancel = nullptr) const;
  /// Stores the folder's file in an origin, if there is one. Errors: those of OriginScenes and of
  /// io_error.
  Status publish(OriginScenes& origin, std::uint64_t content, const std::string& sha256) const;

  /// Removes the tree files of a scene's file from `folder`.
  static void forget(const std::filesystem::path& folder, const std::string& sha256);
  /// The hash of the scene's file to which a file of trees belongs; empty if it belongs to none.
  static std::string owner_of(const std::filesystem::path& file);

 private:
  std::filesystem::path path_of(std::uint64_t content, const std::string& sha256) const;
  void make_room(std::uint64_t bytes) const;

  std::filesystem::path folder_;
  std::uint64_t bytes_max_;
};

}  // namespace sightline

// Tests: tests/unit/store/tree_cache_manager_test.cpp
