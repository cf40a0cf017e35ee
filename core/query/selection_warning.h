#pragma once
/// SelectionWarning: a part of a filter that matches nothing in the scene.
/// core/run/resolved_filter.h makes them.

#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// The code of this warning, and of the error in requests where it is an error.
inline constexpr std::string_view kSelectionEmpty = "SELECTION_EMPTY";

/// A warning about one entry of a filter.
struct SelectionWarning {
  std::string pointer;  ///< JSON pointer (RFC 6901) to the entry in the filter: "/include/names/0"
  std::string message;  ///< one sentence, with similar names of the scene if there are any
};
using SelectionWarnings = std::vector<SelectionWarning>;

}  // namespace sightline

// Tests: tests/unit/run/filter_test.cpp
