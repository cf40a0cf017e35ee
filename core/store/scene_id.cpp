#include "core/store/scene_id.h"

#include <algorithm>

namespace sightline {

bool is_scene_id(std::string_view id) {
  if (id.empty() || id.size() > 128 || id.front() == '.') return false;
  // Written out: isalnum depends on the locale.
  return std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

Error scene_id_invalid() {
  return {ErrorKind::kInvalid, "SCENE_ID_INVALID",
          "a scene's name has 1 to 128 of the characters A-Z a-z 0-9 . _ - and does not begin with "
          "a dot",
          ""};
}

Error scene_not_found() {
  return {ErrorKind::kNotFound, "SCENE_NOT_FOUND", "there is no scene of this name", ""};
}

}  // namespace sightline
