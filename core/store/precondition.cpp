#include "core/store/precondition.h"

#include <algorithm>

namespace sightline {

bool TagList::names(const std::string& tag) const {
  return !tag.empty() && (any || std::find(tags.begin(), tags.end(), tag) != tags.end());
}

Status Precondition::check(const std::string& tag) const {
  const bool holds = (!match || match->names(tag)) && (!none_match || !none_match->names(tag));
  if (holds) return success();
  return Error{ErrorKind::kPrecondition, "PRECONDITION_FAILED",
               tag.empty() ? "the scene has no content yet"
               : match && !match->names(tag)
                   ? "the scene is another one: its ETag is \"" + tag + "\""
                   : "the scene is there already: its ETag is \"" + tag + "\"",
               ""};
}

}  // namespace sightline
