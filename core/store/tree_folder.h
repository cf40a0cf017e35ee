#pragma once
/// Trees between two runs (core/scene/tree_cache.h). Nothing depends on them: what is missing,
/// foreign, stale or damaged is built again.
///
///     DIR/<sha256>-<content>.trees   of a scene whose bytes a data folder keeps; goes with them
///     DIR/<content>.trees            of any other
///     DIR/writing                    what is being written

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/scene/scene_trees.h"
#include "core/store/posix_file.h"

namespace sightline {

class TreeFolder {
 public:
  /// The folder is made when the first file is written. Beyond `bytes_max` the files that were used
  /// the longest ago go.
  explicit TreeFolder(std::filesystem::path folder,
                      std::uint64_t bytes_max = std::uint64_t{64} << 30)
      : folder_(std::move(folder)), bytes_max_(bytes_max) {}

  /// Empty where there is no file. The trees stay in the memory that the file was read to. Errors:
  /// those of decode_trees, STORE_IO; a file with such a fault is removed.
  Result<std::optional<SceneTree>> read(const ScenePlan& plan, std::uint64_t content,
                                        const std::string& sha256) const;
  /// Durable on return; at any moment the file is whole or not there. Errors: STORE_IO, STORE_FULL;
  /// CANCELLED, soon after `cancel` is.
  Status write(const SceneTree& tree, std::uint64_t content, const std::string& sha256,
               const CancelFlag* cancel = nullptr) const;

  /// Removes the files of those bytes from the folder of trees `folder`.
  static void forget(const std::filesystem::path& folder, const std::string& sha256);
  /// The bytes that a file belongs to; empty if it belongs to none.
  static std::string owner_of(const std::filesystem::path& file);

 private:
  std::filesystem::path path_of(std::uint64_t content, const std::string& sha256) const;
  void make_room(std::uint64_t bytes) const;

  std::filesystem::path folder_;
  std::uint64_t bytes_max_;
};

}  // namespace sightline

// Tests: tests/unit/store/tree_cache_manager_test.cpp
