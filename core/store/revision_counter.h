#pragma once
/// RevisionCounter: numbers of contents. No number is given twice, over all names of a store and
/// all of its runs.

#include <cstdint>
#include <filesystem>
#include <utility>

#include "core/base/result.h"

namespace sightline {

/// The largest revision. Every JSON reader can represent it.
inline constexpr std::uint64_t kMostRevision = std::uint64_t{1} << 53;

/// Gives ascending numbers, and stores the last one in a file. Not thread-safe.
class RevisionCounter {
 public:
  /// A counter in memory, for a store without a folder: 1, 2, 3, ...
  RevisionCounter() = default;
  /// Continues after the number in the file DIR/revision, or after `seen` if there is no such file;
  /// `seen` is the largest number in use. If the file cannot be read, its number is unknown; then
  /// the counter skips far more numbers than a server ever gives. Errors: STORE_DAMAGED if a folder
  /// is in the place of the file, because no number could be written.
  static Result<RevisionCounter> open(const std::filesystem::path& folder, std::uint64_t seen);

  /// Takes `count` consecutive numbers, and returns the last one after the file is durably updated.
  /// Errors: those of io_error; the numbers are then skipped for ever.
  Result<std::uint64_t> next(std::uint64_t count = 1);

 private:
  RevisionCounter(std::filesystem::path folder, std::uint64_t last)
      : folder_(std::move(folder)), last_(last) {}

  std::filesystem::path folder_;  ///< empty: no file
  std::uint64_t last_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_record_test.cpp
