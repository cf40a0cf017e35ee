#include "proto/json/strict_json.h"

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include "proto/json/json_pointer.h"
#include "proto/json/json_token.h"

namespace sightline {

namespace {

using Json = nlohmann::json;

/// Finds a key that an object has twice: the library retains the last one, another reader on the way
/// may retain the first. A callback of Json::parse would compare each object with all before it.
class KeyCheck : public nlohmann::json_sax<Json> {
 public:
  std::optional<std::string> twice;
  std::size_t read = 0;  ///< so many bytes, the last of which is no JSON

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool start_object(std::size_t) override {
    open_.emplace_back();
    return true;
  }
  bool end_object() override {
    open_.pop_back();
    return true;
  }
  bool key(string_t& name) override {
    if (!open_.back().insert(name).second) twice = name;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception&) override {
    read = position;
    return false;
  }

 private:
  std::vector<std::set<std::string>> open_;
};

}  // namespace

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
  KeyCheck check;
  if (!Json::sax_parse(body, &check)) {
    const std::size_t at = check.read - std::min<std::size_t>(check.read, 1);
    return Error{ErrorKind::kMalformed, "JSON_MALFORMED",
                 "the body is not JSON" + near_line(body, at), ""};
  }
  if (check.twice) {
    return fault("KEY_DUPLICATE", "this key is there twice", below("", *check.twice));
  }
  return Json::parse(body, nullptr, false);
}

}  // namespace sightline
