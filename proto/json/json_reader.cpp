#include "proto/json/json_reader.h"

#include <algorithm>
#include <charconv>

#include "proto/json/json_token.h"

namespace sightline {

bool JsonReader::wrong(Value value, const JsonPointer& place, std::string_view expected) {
  const std::string_view token = trim(value.raw_json_token());
  if (is_non_finite_word(token)) {
    return fail(ErrorKind::kInvalid, "NUMBER_NOT_FINITE", "NaN and infinities are not JSON numbers",
                place);
  }
  if (!looks_like_json(token)) return malformed(place, "no value of JSON is written like this");
  if (is_json_number(token) && expected == "a number") {
    return fail(ErrorKind::kInvalid, "NUMBER_NOT_FINITE", "this number overflows a float64", place);
  }
  return fail(ErrorKind::kInvalid, "TYPE_WRONG",
              "expected " + std::string(expected) + ", found " + std::string(token_kind(token)),
              place);
}

/// simdjson 3.0.1 takes 0.1000000000000000055511151231257827 for a number near 1e-16. Where a zero
/// stands before the point, it counts the zeros behind it instead of the digits after them to see
/// whether these fit in 64 bits. So such a number is read once more.
void JsonReader::read_long_fraction(std::string_view token, double& out) {
  const std::size_t first = token.front() == '-' ? 1 : 0;
  if (token[first] != '0') return;
  double again = 0;
  // Out of range is what is too small for a float64 (simdjson has refused what is too large). With
  // so many zeros simdjson takes its exact path.
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), again);
  if (error == std::errc()) out = again;
}

bool JsonReader::is_null(Value value) { return trim(value.raw_json_token()) == "null"; }

bool JsonReader::has_last_bracket(std::string_view text) {
  text = trim(text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size())));
  if (text.starts_with('{')) return text.ends_with('}');
  return !text.starts_with('[') || text.ends_with(']');
}

bool JsonReader::fail_document(simdjson::ondemand::document& document, simdjson::error_code code) {
  std::string_view token;
  if (code == simdjson::INCORRECT_TYPE && document.raw_json_token().get(token) == 0 &&
      looks_like_json(trim(token))) {
    return invalid("TYPE_WRONG", "expected an object as the whole body", {});
  }
  if (code == simdjson::INCORRECT_TYPE) return malformed({}, "the body does not begin like JSON");
  return fail_parse(code, {});
}

void JsonReader::tell_line(std::string_view body, const char* place) {
  if (error_.code != "JSON_MALFORMED" || place < body.data()) return;
  error_.message += near_line(body, static_cast<std::size_t>(place - body.data()));
}

bool JsonReader::fail_parse(simdjson::error_code code, const JsonPointer& place) {
  // In our own words: the library's speak of its inside, and change with its version.
  switch (code) {
    case simdjson::MEMALLOC:
      return fail(ErrorKind::kOutOfSpace, "MEMORY_FULL", "there is no memory left to read the body",
                  {});
    case simdjson::CAPACITY:
      return fail(ErrorKind::kTooLarge, "BODY_TOO_LARGE", "the body is too large for JSON", {});
    case simdjson::EMPTY:
      return malformed(place, "the body is empty");
    case simdjson::UTF8_ERROR:
      return malformed(place, "the body is not UTF-8");
    case simdjson::UNCLOSED_STRING:
      return malformed(place, "a string has no end");
    case simdjson::UNESCAPED_CHARS:
      return malformed(place, "a string holds a control character that is not escaped");
    case simdjson::INCOMPLETE_ARRAY_OR_OBJECT:
      // The parser says so of text behind the object as well: it reads the last bracket only.
      return malformed(place, "the body does not end with the closing bracket of its object");
    case simdjson::DEPTH_ERROR:
      return malformed(place, "this is nested too deeply");
    default:
      return malformed(place,
                       "a comma, a colon, a quote or a bracket here is missing, or one too many");
  }
}

bool JsonReader::read_key(Field& field, std::span<const std::string_view> keys, unsigned known,
                          const JsonPointer& parent, std::size_t& which) {
  const auto is_known = [&](std::size_t i) { return ((known >> i) & 1u) != 0; };
  const simdjson::ondemand::raw_json_string raw = field.key();
  for (which = 0; which < keys.size(); ++which) {
    if (is_known(which) && raw.unsafe_is_equal(keys[which])) return true;
  }
  // A name may also be written with escapes.
  std::string_view name;
  if (field.unescaped_key().get(name) != simdjson::SUCCESS) {
    return malformed(parent, "a key here is not a valid string");
  }
  std::string list;
  for (which = 0; which < keys.size(); ++which) {
    if (!is_known(which)) continue;
    if (name == keys[which]) return true;
    list += (list.empty() ? "" : ", ") + std::string(keys[which]);
  }
  return fail(ErrorKind::kInvalid, "KEY_UNKNOWN",
              "unknown key \"" + std::string(cut_utf8(name, 64)) + "\"; known here: " + list,
              JsonPointer(parent).key(name));
}

bool JsonReader::mark_seen(unsigned bit, unsigned& seen, const JsonPointer& place) {
  if ((seen & bit) != 0) {
    return fail(ErrorKind::kInvalid, "KEY_DUPLICATE", "this key stands here twice", place);
  }
  seen |= bit;
  return true;
}

bool JsonReader::read_boolean(Value value, bool& out, const JsonPointer& place) {
  if (value.get_bool().get(out) == simdjson::SUCCESS) return true;
  return wrong(value, place, "true or false");
}

bool JsonReader::read_count(Value value, std::uint64_t most, std::uint64_t& out,
                            const JsonPointer& place) {
  const std::string expected = "an integer from 0 to " + std::to_string(most);
  const bool integer = value.get_uint64().get(out) == simdjson::SUCCESS;
  if (!integer && !is_json_number(trim(value.raw_json_token()))) {
    return wrong(value, place, expected);
  }
  if (!integer || out > most) return invalid("NUMBER_OUT_OF_RANGE", "expected " + expected, place);
  return true;
}

bool JsonReader::read_timeout(Value value, std::optional<std::uint64_t>& out,
                              const JsonPointer& place) {
  return read_count(value, 86'400'000, out.emplace(), place);
}

bool JsonReader::read_threads(Value value, int& out, const JsonPointer& place) {
  constexpr std::uint64_t kMost = 1024;
  std::uint64_t number = 0;
  if (!read_count(value, kMost, number, place)) return false;
  out = static_cast<int>(number);
  return number > 0 || invalid("NUMBER_OUT_OF_RANGE", "expected 1 to 1024", place);
}

bool JsonReader::read_word(Value value, std::span<const std::string_view> words, std::size_t& which,
                           const JsonPointer& place) {
  std::string expected;
  for (const std::string_view word : words) {
    expected += (expected.empty() ? "\"" : " or \"") + std::string(word) + "\"";
  }
  std::string_view name;
  if (const auto code = value.get_string().get(name); code != simdjson::SUCCESS) {
    if (code == simdjson::INCORRECT_TYPE) return wrong(value, place, expected);
    return malformed(place, "this is not a valid string");
  }
  for (which = 0; which < words.size(); ++which) {
    if (name == words[which]) return true;
  }
  return invalid("VALUE_UNKNOWN", "expected " + expected, place);
}

}  // namespace sightline
