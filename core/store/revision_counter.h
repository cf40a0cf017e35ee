#pragma once
/// Numbers for contents: over all names of a store, and over all of its runs, none is given twice.

#include <cstdint>
#include <filesystem>

#include "core/base/result.h"

namespace sightline {

/// Every JSON reader can hold it.
inline constexpr std::uint64_t kMostRevision = std::uint64_t{1} << 53;

/// Not to be used from several threads at once.
class RevisionCounter {
 public:
  /// In memory: 1, 2, 3, ...
  RevisionCounter() = default;
  /// Goes on after the number that DIR/revision states. `seen` is the largest that is in use:
  /// where there is no such file, it goes on after that. A file that cannot be read may have stated
  /// more; then far more is left out than one server ever gives.
  RevisionCounter(const std::filesystem::path& folder, std::uint64_t seen);

  /// Takes `count` consecutive numbers and returns the last, once it is durable that they are
  /// taken. Errors: STORE_IO, STORE_FULL; the numbers are then lost.
  Result<std::uint64_t> next(std::uint64_t count = 1);

 private:
  std::filesystem::path folder_;  ///< empty: in memory
  std::uint64_t last_ = 0;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_record_test.cpp
