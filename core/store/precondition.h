#pragma once
/// Precondition: which content a scene must have for a request to change it [RFC9110] 13.1.

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace sightline {

/// The entity tags of an If-Match or If-None-Match header.
struct TagList {
  bool any = false;  ///< "*": matches any content
  std::vector<std::string> tags;

  /// True if the list matches `tag`, the entity tag of a content; an empty `tag` means that there
  /// is no content.
  bool names(const std::string& tag) const;
};

/// The conditions of a request: its If-Match and If-None-Match, if it has them. Without both
/// headers, every change is allowed.
struct Precondition {
  std::optional<TagList> match, none_match;

  /// Checks if a content with this entity tag may be changed; an empty `tag` means that there is no
  /// content. Errors: PRECONDITION_FAILED.
  Status check(const std::string& tag) const;
};

}  // namespace sightline

// Tests: tests/unit/store/scene_store_test.cpp
