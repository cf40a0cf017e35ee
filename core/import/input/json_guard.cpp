#include "core/import/input/json_guard.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/import/input/refusal.h"

namespace sightline::gltf {

namespace {

/// What nlohmann found, in our own words: its own speak of its inside and echo the text.
std::string_view fault_of(const nlohmann::json::exception& e) {
  constexpr int kOutOfRange = 406;
  if (e.id == kOutOfRange) return "a number here overflows a float64";
  constexpr std::pair<std::string_view, std::string_view> kFaults[] = {
      {"missing closing quote", "a string has no end"},
      {"ill-formed UTF-8", "a string is not UTF-8"},
      {"control character", "a string holds a control character that is not escaped"},
      {"invalid string", "a string has an escape that JSON does not know"},
      {"invalid number", "a number is not written as JSON writes numbers"},
      {"invalid BOM", "the byte order mark is incomplete"},
      {"unexpected end of input", "the text ends before its last bracket is closed"},
      {"expected end of input", "there is text after the end of the file's object"},
      {"object key", "a key in double quotes is expected here"},
      {"invalid literal", "no value of JSON is written like this"},
  };
  std::string_view what = e.what();
  what = what.substr(0, what.find("; last read"));
  for (const auto& [theirs, ours] : kFaults) {
    if (what.find(theirs) != std::string_view::npos) return ours;
  }
  return "a comma, a colon, a bracket or a value is missing, or one too many";
}

/// nlohmann's SAX interface: a handler that returns false ends the parse.
class Guard {
 public:
  using number_integer_t = nlohmann::json::number_integer_t;
  using number_unsigned_t = nlohmann::json::number_unsigned_t;
  using number_float_t = nlohmann::json::number_float_t;
  using string_t = nlohmann::json::string_t;
  using binary_t = nlohmann::json::binary_t;

  Guard(const ImportLimits& limits, std::size_t bytes) : limits_(limits) { size_.bytes = bytes; }

  Result<JsonSize> verdict() && {
    if (error_.code.empty()) return size_;
    return std::move(error_);
  }

  bool null() { return value(); }
  bool boolean(bool) { return value(); }
  bool number_integer(number_integer_t) { return value(); }
  bool number_unsigned(number_unsigned_t) { return value(); }
  bool number_float(number_float_t, const string_t&) { return value(); }
  bool string(string_t&) {
    ++size_.strings;
    return value();
  }
  bool binary(binary_t&) { return value(); }
  bool start_object(std::size_t) {
    ++size_.objects;
    return value() && open(false);
  }
  bool start_array(std::size_t) {
    ++size_.arrays;
    return value() && open(true);
  }

  bool key(string_t& name) {
    open_.back().key = keys_.size();
    open_.back().awaits_value = true;
    keys_.push_back(name);
    ++size_.members;
    return true;
  }

  bool end_object() {
    // The keys of this object are the last ones; sorted, a repeated one stands beside its twin.
    const auto first = keys_.begin() + static_cast<std::ptrdiff_t>(open_.back().first_key);
    std::sort(first, keys_.end());
    const auto twin = std::adjacent_find(first, keys_.end());
    const bool unique = twin == keys_.end();
    if (!unique) {
      const std::string name = shortened(*twin);
      open_.pop_back();
      error_ = malformed("GLTF_JSON_DUPLICATE_KEY",
                         "an object names the key \"" + name + "\" more than once", pointer());
      return false;
    }
    keys_.erase(first, keys_.end());
    open_.pop_back();
    return true;
  }

  bool end_array() {
    open_.pop_back();
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& e) {
    error_ = malformed("GLTF_JSON_INVALID",
                       "the file's JSON is broken at byte " + std::to_string(position) + ": " +
                           std::string(fault_of(e)),
                       pointer_of_fault());
    return false;
  }

 private:
  struct Frame {
    bool array = false;
    std::size_t index = 0;      ///< of the current element, counted from 1 once it began
    std::size_t key = 0;        ///< of the current member, in keys_; beyond it before the first
    std::size_t first_key = 0;  ///< of this object, in keys_
    bool awaits_value = false;  ///< a key stands there, its value does not yet
  };

  bool value() {
    if (!open_.empty()) open_.back().awaits_value = false;
    if (!open_.empty() && open_.back().array) {
      ++open_.back().index;
      ++size_.elements;
    }
    if (++size_.values <= limits_.json_values) return true;
    error_ = beyond_limit("JSON_VALUES", "values in the JSON text", size_.values,
                          limits_.json_values, pointer());
    return false;
  }

  bool open(bool array) {
    if (open_.size() >= limits_.json_depth) {
      error_ = beyond_limit("JSON_DEPTH", "nesting of the JSON text", open_.size() + 1,
                            limits_.json_depth, pointer());
      return false;
    }
    open_.push_back({array, 0, static_cast<std::size_t>(-1), keys_.size(), false});
    return true;
  }

  std::string pointer() const { return pointer_of(open_); }

  /// The member whose value is broken, else the array or object in which something is.
  std::string pointer_of_fault() const {
    const std::size_t known = open_.empty() || open_.back().awaits_value ? 0 : 1;
    return pointer_of(std::span(open_).first(open_.size() - known));
  }

  std::string pointer_of(std::span<const Frame> frames) const {
    std::string out;
    for (const Frame& frame : frames) {
      if (frame.array && frame.index > 0) out += "/" + std::to_string(frame.index - 1);
      if (!frame.array && frame.key < keys_.size()) out += "/" + shortened(keys_[frame.key]);
      if (out.size() > 200) break;
    }
    return out;
  }

  const ImportLimits& limits_;
  JsonSize size_;
  std::vector<Frame> open_;
  std::vector<std::string> keys_;  ///< of all open objects
  Error error_;
};

}  // namespace

Result<JsonSize> guard_json(std::string_view text, const ImportLimits& limits) {
  if (text.size() > limits.json_bytes) {
    return beyond_limit("JSON_BYTES", "bytes of JSON", text.size(), limits.json_bytes);
  }
  Guard guard(limits, text.size());
  nlohmann::json::sax_parse(text.begin(), text.end(), &guard);
  return std::move(guard).verdict();
}

}  // namespace sightline::gltf
