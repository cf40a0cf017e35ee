#include "proto/json/strict_json.h"

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include "proto/json/json_pointer.h"

namespace sightline {

Error fault(const char* code, std::string message, std::string pointer) {
  return {ErrorKind::kInvalid, code, std::move(message), std::move(pointer)};
}

std::string below(const std::string& place, std::string_view key) {
  return place + JsonPointer().key(key).text();
}

Status check_object(const nlohmann::json& value, const std::string& place,
                    std::initializer_list<std::string_view> known) {
  if (!value.is_object()) return fault("TYPE_WRONG", "this must be an object", place);
  for (const auto& [key, unused] : value.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string names;
    for (const std::string_view name : known) {
      names += names.empty() ? "" : ", ";
      names += name;
    }
    return fault("KEY_UNKNOWN", "there is no such key; there are " + names, below(place, key));
  }
  return success();
}

Result<nlohmann::json> parse_strictly(std::string_view body) {
  // The library retains the last of two equal keys; another reader on the way may retain the first.
  std::vector<std::set<std::string>> open;
  std::optional<std::string> twice;
  const auto look = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    if (event == nlohmann::json::parse_event_t::object_start) open.emplace_back();
    if (event == nlohmann::json::parse_event_t::object_end) open.pop_back();
    if (event == nlohmann::json::parse_event_t::key &&
        !open.back().insert(parsed.get<std::string>()).second) {
      twice = parsed.get<std::string>();
    }
    return true;
  };
  nlohmann::json document = nlohmann::json::parse(body, look, false);
  if (document.is_discarded()) {
    return Error{ErrorKind::kMalformed, "JSON_MALFORMED", "the body is not JSON", ""};
  }
  if (twice) return fault("KEY_DUPLICATE", "this key is there twice", below("", *twice));
  return document;
}

}  // namespace sightline
