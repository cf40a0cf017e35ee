#pragma once
/// JsonReader: the common part of the readers of JSON bodies. It is strict, and its errors name the
/// place. For files of this room that use simdjson.

// Lets the parser check the end of the text as well, because bodies are not trusted.
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

/// The bytes of capacity that must follow a body, because the parser reads in blocks.
inline constexpr std::size_t kJsonPadding = 64;
static_assert(kJsonPadding >= simdjson::SIMDJSON_PADDING);

/// Reads the values of one body, and holds the first error. Derive from it, or hold one for each
/// body; not thread-safe. Each read_ function returns false if there is an error, which error()
/// then returns; the output parameters are then unspecified. `place` is the pointer of the value,
/// for errors. Values and fields are valid while the body is being read.
class JsonReader {
 public:
  using Value = simdjson::ondemand::value;
  using Object = simdjson::ondemand::object;
  using Array = simdjson::ondemand::array;
  using Field = simdjson::ondemand::field;

  /// Reads the whole body as one object: calls read_object(object), which returns false after it
  /// has set an error. The capacity of `body` grows by kJsonPadding if needed; its text is not
  /// changed. Cost: one parser for each call.
  template <class ReadObject>
  bool read_body(std::string& body, ReadObject read_object);

  /// Reads `text` as one value: calls read_value(value), which returns false after it has set an
  /// error. `capacity` bytes from the beginning of `text` are readable: at least kJsonPadding more
  /// than its size. place() returns the pointer of the value.
  template <class Place, class ReadValue>
  bool read_one(simdjson::ondemand::parser& parser, std::string_view text, std::size_t capacity,
                Place place, ReadValue read_value);

  // Functions that read one value. place() returns the pointer, and is only called for an error.
  /// Reads a number as the nearest float64. Errors: TYPE_WRONG, NUMBER_NOT_FINITE, JSON_MALFORMED.
  template <class Place>
  bool read_number(Value value, double& out, Place place);
  /// Reads a number; null gives `if_null`.
  template <class Place>
  bool read_number_or_null(Value value, double if_null, double& out, Place place);
  bool read_boolean(Value value, bool& out, const JsonPointer& place);
  /// Reads an integer from 0 to `most`.
  bool read_count(Value value, std::uint64_t most, std::uint64_t& out, const JsonPointer& place);
  /// Reads a number of milliseconds, at most a day.
  bool read_timeout(Value value, std::optional<std::uint64_t>& out, const JsonPointer& place);
  /// Reads a limit of threads, 1 to 1024.
  bool read_threads(Value value, int& out, const JsonPointer& place);
  /// Reads one of `words`; `which` is set to its index.
  bool read_word(Value value, std::span<const std::string_view> words, std::size_t& which,
                 const JsonPointer& place);
  /// Calls read_element(index, value) for each element. read_element may read its value once only.
  /// `expected` names the array in errors.
  template <class ReadElement>
  bool read_array(Value value, std::string_view expected, const JsonPointer& place,
                  ReadElement read_element);

  /// Reads an object of a few members: calls read_member(which, value, place of the member) for
  /// each. `keys`, `known` and `which` are those of read_key; `seen` gets the bit of each key.
  template <class ReadMember>
  bool read_members(Value value, std::span<const std::string_view> keys, unsigned known,
                    const JsonPointer& place, unsigned& seen, ReadMember read_member);

  /// Reads the key of a member. `known` has a bit for each of `keys` that is allowed here; `which`
  /// is set to the index of the key.
  bool read_key(Field& field, std::span<const std::string_view> keys, unsigned known,
                const JsonPointer& parent, std::size_t& which);
  /// Sets `bit` in `seen`. If it is set already, the key is duplicate, which is an error.
  bool mark_seen(unsigned bit, unsigned& seen, const JsonPointer& place);
  /// Returns true if the parser reports success. Otherwise the error is MEMORY_FULL, BODY_TOO_LARGE
  /// or JSON_MALFORMED.
  template <class Place>
  bool check_end(simdjson::error_code code, Place place);

  /// Sets the error and returns false. invalid() and malformed() are its usual kinds.
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
  /// Sets an error that tells why `value` is not `expected`. Returns false.
  bool wrong(Value value, const JsonPointer& place, std::string_view expected);

  /// The error after a false of a read_ function.
  const Error& error() const { return error_; }

 private:
  /// Returns false, without setting the error, if `value` is not a number of float64.
  static bool read_float64(Value value, double& out) {
    // "0." and 20 digits. simdjson may read a longer number wrongly, and never a shorter one.
    constexpr std::size_t kLong = 22;
    const std::string_view token = value.raw_json_token();
    if (value.get_double().get(out) != simdjson::SUCCESS) return false;
    if (token.size() >= kLong) read_long_fraction(token, out);
    return true;
  }
  static void read_long_fraction(std::string_view token, double& out);
  bool is_null(Value value);
  bool fail_parse(simdjson::error_code code, const JsonPointer& place);
  /// True if `text` begins with a byte order mark. simdjson 3.12 (Debian 13) skips it, 3.0 does
  /// not.
  static bool begins_with_mark(std::string_view text) { return text.starts_with("\xef\xbb\xbf"); }
  /// False if `text` begins an object or an array, and does not end with a closing bracket.
  static bool has_last_bracket(std::string_view text);
  /// Appends the line and the column of `place` in `body` to the message of a syntax error.
  void tell_line(std::string_view body, const char* place);
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
  if (!read_object(object)) {
    const char* place = nullptr;
    if (document.current_location().get(place) == simdjson::SUCCESS) tell_line(body, place);
    return false;
  }
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
  // The parser checks this for a whole document only, and would read beyond the end of such a
  // value.
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
    // The attempt above has already consumed the token.
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

template <class ReadMember>
bool JsonReader::read_members(Value value, std::span<const std::string_view> keys, unsigned known,
                              const JsonPointer& place, unsigned& seen, ReadMember read_member) {
  Object object;
  if (value.get_object().get(object) != simdjson::SUCCESS) return wrong(value, place, "an object");
  for (auto entry : object) {
    Field field;
    if (const auto code = std::move(entry).get(field); code != simdjson::SUCCESS) {
      return check_end(code, [&] { return JsonPointer(place); });
    }
    std::size_t which = 0;
    if (!read_key(field, keys, known, place, which)) return false;
    const JsonPointer part = JsonPointer(place).key(keys[which]);
    if (!mark_seen(1u << which, seen, part) || !read_member(which, field.value(), part)) {
      return false;
    }
  }
  return true;
}

}  // namespace sightline
