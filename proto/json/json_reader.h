#pragma once
/// The common part of the readers of JSON bodies: strictness, and errors that name the place. For
/// the files of this room that read with simdjson, and no others.

// Checks of the end of the text inside the parser as well: this room trusts no body.
#define SIMDJSON_CHECK_EOF 1
#include <simdjson.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "proto/json/json_pointer.h"

namespace sightline {

/// Capacity behind its end that a body needs, because the parser reads in blocks.
inline constexpr std::size_t kJsonPadding = 64;
static_assert(kJsonPadding >= simdjson::SIMDJSON_PADDING);

/// Every read_... returns false after it has filled error(); nothing is read then.
class JsonReader {
 public:
  using Value = simdjson::ondemand::value;
  using Object = simdjson::ondemand::object;
  using Array = simdjson::ondemand::array;
  using Field = simdjson::ondemand::field;

  /// Reads the whole body as one object: calls read_object(object), which returns a bool.
  template <class ReadObject>
  bool read_body(std::string& body, ReadObject read_object);

  /// Reads `text` as one value: calls read_value(value). The parser may read up to `capacity` bytes
  /// from the beginning of `text`.
  template <class Place, class ReadValue>
  bool read_one(simdjson::ondemand::parser& parser, std::string_view text, std::size_t capacity,
                Place place, ReadValue read_value);

  // Single values. `place` makes the pointer, and is only called when there is something to say.
  template <class Place>
  bool read_number(Value value, double& out, Place place);
  /// null stands for `if_null`.
  template <class Place>
  bool read_number_or_null(Value value, double if_null, double& out, Place place);
  bool read_boolean(Value value, bool& out, const JsonPointer& place);
  bool read_count(Value value, std::uint64_t most, std::uint64_t& out, const JsonPointer& place);
  /// Milliseconds, at most a day of them.
  bool read_timeout(Value value, std::optional<std::uint64_t>& out, const JsonPointer& place);
  /// One of a few words; `which` is its index.
  bool read_word(Value value, std::span<const std::string_view> words, std::size_t& which,
                 const JsonPointer& place);
  /// Calls read_element(index, value) for each; it may not read more than once.
  template <class ReadElement>
  bool read_array(Value value, std::string_view expected, const JsonPointer& place,
                  ReadElement read_element);

  /// `known`: the bits of those of `keys` that may stand here.
  bool read_key(Field& field, std::span<const std::string_view> keys, unsigned known,
                const JsonPointer& parent, std::size_t& which);
  bool mark_seen(unsigned bit, unsigned& seen, const JsonPointer& place);
  /// False, with MEMORY_FULL, BODY_TOO_LARGE or JSON_MALFORMED, unless the parser was content.
  template <class Place>
  bool check_end(simdjson::error_code code, Place place);

  bool fail(ErrorKind kind, std::string_view code, std::string message, const JsonPointer& place) {
    error_ = Error{kind, std::string(code), std::move(message), place.text()};
    return false;
  }
  bool invalid(std::string_view code, std::string message, const JsonPointer& place) {
    return fail(ErrorKind::kInvalid, code, std::move(message), place);
  }
  bool malformed(const JsonPointer& place, std::string message) {
    return fail(ErrorKind::kMalformed, "JSON_MALFORMED", std::move(message), place);
  }
  /// Says why `value` is not what was expected there.
  bool wrong(Value value, const JsonPointer& place, std::string_view expected);

  const Error& error() const { return error_; }

 private:
  /// False, and nothing in error(), for what is not a number of float64.
  static bool read_float64(Value value, double& out) {
    // "0." and 20 digits: fewer bytes cannot be a number that the library reads wrongly.
    constexpr std::size_t kLong = 22;
    const std::string_view token = value.raw_json_token();
    if (value.get_double().get(out) != simdjson::SUCCESS) return false;
    if (token.size() >= kLong) read_long_fraction(token, out);
    return true;
  }
  static void read_long_fraction(std::string_view token, double& out);
  bool is_null(Value value);
  bool fail_parse(simdjson::error_code code, const JsonPointer& place);
  /// Whether `text` begins with a byte order mark. simdjson 3.12 (Debian 13) skips it, 3.0 does not.
  static bool begins_with_mark(std::string_view text) { return text.starts_with("\xef\xbb\xbf"); }
  /// Whether an object or an array that begins `text` may end there too.
  static bool has_last_bracket(std::string_view text);
  bool fail_document(simdjson::ondemand::document& document, simdjson::error_code code);

  Error error_;
};

template <class ReadObject>
bool JsonReader::read_body(std::string& body, ReadObject read_object) {
  // The on-demand front is compiled for any machine; its first stage, where the time goes, is
  // chosen at run time for this one.
  simdjson::ondemand::parser parser;
  body.reserve(body.size() + kJsonPadding);
  simdjson::ondemand::document document;
  if (begins_with_mark(body)) return malformed({}, "the body does not begin like JSON");
  if (const auto code = parser.iterate(body).get(document); code != simdjson::SUCCESS) {
    return fail_parse(code, {});
  }
  Object object;
  if (const auto code = document.get_object().get(object); code != simdjson::SUCCESS) {
    return fail_document(document, code);
  }
  if (!read_object(object)) return false;
  if (document.current_location().error() != simdjson::OUT_OF_BOUNDS) {
    return malformed({}, "there is text after the body's object");
  }
  return true;
}

template <class Place, class ReadValue>
bool JsonReader::read_one(simdjson::ondemand::parser& parser, std::string_view text,
                          std::size_t capacity, Place place, ReadValue read_value) {
  simdjson::ondemand::document document;
  if (begins_with_mark(text)) return malformed(place(), "each line has one object");
  const simdjson::padded_string_view padded(text.data(), text.size(), capacity);
  if (const auto code = parser.iterate(padded).get(document); code != simdjson::SUCCESS) {
    return fail_parse(code, place());
  }
  // The parser knows this of a whole document, and walks past the end of a value that has none.
  if (!has_last_bracket(text)) {
    return fail_parse(simdjson::INCOMPLETE_ARRAY_OR_OBJECT, place());
  }
  Value value;
  if (document.get_value().get(value) != simdjson::SUCCESS) {
    return malformed(place(), "each line has one object");
  }
  if (!read_value(value)) return false;
  if (document.current_location().error() != simdjson::OUT_OF_BOUNDS) {
    return malformed(place(), "there is text after the line's object");
  }
  return true;
}

template <class Place>
bool JsonReader::read_number(Value value, double& out, Place place) {
  if (read_float64(value, out)) return true;
  return wrong(value, place(), "a number");
}

template <class Place>
bool JsonReader::read_number_or_null(Value value, double if_null, double& out, Place place) {
  if (read_float64(value, out)) return true;
  if (is_null(value)) {
    // The try has stepped over the token already.
    out = if_null;
    return true;
  }
  return wrong(value, place(), "a number");
}

template <class Place>
bool JsonReader::check_end(simdjson::error_code code, Place place) {
  if (code == simdjson::SUCCESS) return true;
  return fail_parse(code, place());
}

template <class ReadElement>
bool JsonReader::read_array(Value value, std::string_view expected, const JsonPointer& place,
                            ReadElement read_element) {
  Array array;
  if (value.get_array().get(array) != simdjson::SUCCESS) return wrong(value, place, expected);
  std::size_t index = 0;
  for (auto element : array) {
    Value item;
    if (const auto code = element.get(item); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return JsonPointer(place).index(index); });
    }
    if (!read_element(index, item)) return false;
    ++index;
  }
  return true;
}

}  // namespace sightline
