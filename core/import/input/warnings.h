#pragma once
/// Warnings: sentences about what an import left out or corrected. Their number is limited, so that
/// a hostile file cannot make too many.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace sightline::gltf {

/// Retains the first kMost sentences, and counts the rest. Not thread-safe.
class Warnings {
 public:
  static constexpr std::size_t kMost = 100;  ///< sentences that are retained

  /// Adds a sentence without a full stop.
  void add(std::string sentence) {
    if (kept_.size() < kMost) {
      kept_.push_back(std::move(sentence));
    } else {
      ++dropped_;
    }
  }
  /// Returns the sentences, and one that tells how many were dropped, if any. Called once.
  std::vector<std::string> take() {
    if (dropped_ > 0) kept_.push_back("and " + std::to_string(dropped_) + " more warnings");
    return std::move(kept_);
  }

 private:
  std::vector<std::string> kept_;
  std::size_t dropped_ = 0;
};

}  // namespace sightline::gltf

// Tests: tests/unit/import/import_test.cpp
