#include "core/store/scene_id.h"

#include <string>

#include "core/base/plain_name.h"

namespace sightline {

bool is_scene_id(std::string_view id) { return is_plain_name(id); }

Error scene_id_invalid() {
  return {ErrorKind::kInvalid, "SCENE_ID_INVALID",
          "a scene's name has 1 to 128 of the characters A-Z a-z 0-9 . _ - and does not begin with "
          "a dot",
          ""};
}

Error scene_not_found(std::string_view id) {
  const std::string name = is_scene_id(id) ? "\"" + std::string(id) + "\"" : "of this name";
  return {ErrorKind::kNotFound, "SCENE_NOT_FOUND", "there is no scene " + name, ""};
}

}  // namespace sightline
