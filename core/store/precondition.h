#pragma once
/// Which content a name must have for a request to change it [RFC9110] 13.1.

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// Of entity tags, as If-Match and If-None-Match name them.
struct TagList {
  bool any = false;  ///< "*": of any content
  std::vector<std::string> tags;

  /// `tag` of a content; empty where there is none.
  bool names(const std::string& tag) const;
};

struct Precondition {
  std::optional<TagList> match, none_match;

  /// Whether a content of this ETag may be changed; empty: there is no content. Errors:
  /// PRECONDITION_FAILED.
  Status check(const std::string& tag) const;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_load_test.cpp
