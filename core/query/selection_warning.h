#pragma once
/// Warnings about choices of triangles that match nothing in the scene.

#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// The code of a warning and of an error for a part of a choice that matches nothing.
inline constexpr std::string_view kSelectionEmpty = "SELECTION_EMPTY";

struct SelectionWarning {
  std::string pointer;  ///< a JSON pointer to the entry: "/include/names/0"
  std::string message;  ///< one sentence, with similar names of the scene where there are some
};
using SelectionWarnings = std::vector<SelectionWarning>;

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
