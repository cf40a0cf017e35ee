#include "core/import/input/json_checker.h"

#include <algorithm>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

using nlohmann::json;

std::string Place::pointer() const {
  const std::string before = up != nullptr ? up->pointer() : "";
  if (index != kMember) return before + "/" + std::to_string(index);
  return name.empty() ? before : before + "/" + std::string(name);
}

std::string Place::text() const {
  const std::string before = up != nullptr ? up->text() : "";
  if (index != kMember) return before + "[" + std::to_string(index) + "]";
  return before.empty() ? std::string(name) : before + "." + std::string(name);
}

void JsonChecker::refuse(const Place& at, const std::string& what) {
  if (good()) error_ = invalid("GLTF_VALUE_INVALID", at.text() + " " + what, at.pointer());
}

json* JsonChecker::array(json& object, const char* key, const Place& at) {
  const auto found = object.find(key);
  if (found == object.end()) return nullptr;
  if (found->is_array()) return &*found;
  refuse(at.member(key), "must be an array");
  return nullptr;
}

json* JsonChecker::object(json& object, const char* key, const Place& at) {
  const auto found = object.find(key);
  if (found == object.end()) return nullptr;
  return is_object(*found, at.member(key)) ? &*found : nullptr;
}

bool JsonChecker::is_object(const json& value, const Place& at) {
  if (value.is_object()) return true;
  refuse(at, "must be an object");
  return false;
}

void JsonChecker::text(const json& object, const char* key, const Place& at) {
  const auto found = object.find(key);
  if (found != object.end() && !found->is_string()) refuse(at.member(key), "must be a string");
}

void JsonChecker::boolean(const json& object, const char* key, const Place& at) {
  const auto found = object.find(key);
  if (found != object.end() && !found->is_boolean()) {
    refuse(at.member(key), "must be true or false");
  }
}

void JsonChecker::numbers(const json& object, const char* key, const Place& at, std::size_t count) {
  const auto found = object.find(key);
  if (found == object.end()) return;
  const Place place = at.member(key);
  if (!found->is_array()) return refuse(place, "must be an array of numbers");
  if (count != 0 && found->size() != count) {
    return refuse(place, "must hold " + std::to_string(count) + " numbers, it holds " +
                             std::to_string(found->size()));
  }
  for (std::size_t i = 0; i < found->size(); ++i) {
    if (!(*found)[i].is_number()) return refuse(place.element(i), "must be a number");
  }
}

std::optional<std::uint64_t> JsonChecker::integer(json& value, const Place& at,
                                                  std::uint64_t most) {
  const auto range = [&] { return "must be an integer from 0 to " + std::to_string(most); };
  if (value.is_number_float()) {
    const double number = value.get<double>();
    // The comparison is false for NaN, and 2^53 bounds the conversion.
    if (number >= 0 && number <= static_cast<double>(kMost) &&
        number == static_cast<double>(static_cast<std::uint64_t>(number))) {
      value = static_cast<std::uint64_t>(number);
    }
  }
  // nlohmann stores non-negative integers as unsigned; the others are negative.
  if (!value.is_number_unsigned()) {
    refuse(at, value.is_number() ? range() + ", it is " + value.dump() : range());
    return std::nullopt;
  }
  const auto number = value.get<std::uint64_t>();
  if (number > most) {
    refuse(at, range() + ", it is " + std::to_string(number));
    return std::nullopt;
  }
  return number;
}

std::optional<std::uint64_t> JsonChecker::integer(json& object, const char* key, const Place& at,
                                                  std::uint64_t most) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  return integer(*found, at.member(key), most);
}

std::uint64_t JsonChecker::required_integer(json& object, const char* key, const Place& at,
                                            std::uint64_t most) {
  if (!object.contains(key)) {
    refuse(at.member(key), "is missing");
    return 0;
  }
  return integer(object, key, at, most).value_or(0);
}

void JsonChecker::reference(json& value, const Place& at, std::size_t count, const char* what) {
  const auto index = integer(value, at);
  if (index.has_value() && *index >= count && good()) {
    error_ = invalid("GLTF_REFERENCE_INVALID",
                     at.text() + " is " + std::to_string(*index) + ", the file has " +
                         std::to_string(count) + " " + what,
                     at.pointer());
  }
}

std::optional<std::uint64_t> JsonChecker::reference(json& object, const char* key, const Place& at,
                                                    std::size_t count, const char* what) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  reference(*found, at.member(key), count, what);
  if (!good()) return std::nullopt;
  return found->get<std::uint64_t>();
}

void JsonChecker::keep_only(json& object, std::initializer_list<const char*> keys) {
  for (auto member = object.begin(); member != object.end();) {
    const bool keep =
        std::any_of(keys.begin(), keys.end(), [&](const char* key) { return member.key() == key; });
    member = keep ? std::next(member) : object.erase(member);
  }
}

}  // namespace sightline::gltf
