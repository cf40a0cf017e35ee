#include "core/import/json_guard.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/import/refusal.h"

namespace sightline::gltf {

namespace {

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
    // "[json.exception.parse_error.101] parse error at line 1, column 2: ...; last read: '...'"
    // minus its number and the bytes that it echoes.
    std::string_view what = e.what();
    what = what.substr(0, what.find("; last read"));
    if (const auto end = what.find("] "); end != std::string_view::npos)
      what.remove_prefix(end + 2);
    error_ = malformed("GLTF_JSON_INVALID",
                       "JSON, byte " + std::to_string(position) + ": " + shortened(what, 200));
    return false;
  }

 private:
  struct Frame {
    bool array = false;
    std::size_t index = 0;      ///< of the current element, counted from 1 once it began
    std::size_t key = 0;        ///< of the current member, in keys_; beyond it before the first
    std::size_t first_key = 0;  ///< of this object, in keys_
  };

  bool value() {
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
    open_.push_back({array, 0, static_cast<std::size_t>(-1), keys_.size()});
    return true;
  }

  std::string pointer() const {
    std::string out;
    for (const Frame& frame : open_) {
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
