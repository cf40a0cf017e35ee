#include "server/operation/config_file.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/store/posix_file.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostBytes = 1 << 20;

/// Bytes that count their lines while the parser takes them.
struct CountingBytes {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char* at;
  int* line;
  reference operator*() const { return *at; }
  CountingBytes& operator++() {
    if (*at == '\n') ++*line;
    ++at;
    return *this;
  }
  CountingBytes operator++(int) {
    const CountingBytes before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingBytes& other) const { return at == other.at; }
  bool operator!=(const CountingBytes& other) const { return at != other.at; }
};

/// Takes the parser's events. A key's line is the present line of the parser.
class Reader final : public nlohmann::json_sax<Json> {
 public:
  Reader(const std::string& file, const int& line, std::vector<std::string>& mistakes)
      : file_(file), line_(line), mistakes_(mistakes) {}

  std::vector<Setting> take() && { return std::move(settings_); }

  bool null() override { return refuse("null is no value"); }
  bool boolean(bool value) override { return add(value ? "true" : "false"); }
  bool number_integer(number_integer_t value) override { return add(std::to_string(value)); }
  bool number_unsigned(number_unsigned_t value) override { return add(std::to_string(value)); }
  bool number_float(number_float_t, const string_t& text) override { return add(text); }
  bool string(string_t& text) override {
    return text.empty() || text.find('\0') != std::string::npos
               ? refuse("a text must not be empty, and has no NUL")
               : add(text);
  }
  bool binary(binary_t&) override { return refuse("bytes are no value"); }
  bool start_object(std::size_t) override {
    return ++depth_ == 1 || refuse("an object is no value");
  }
  bool key(string_t& name) override {
    if (depth_ > 1) return true;
    wrong_ = false;
    settings_.push_back({name, {}, line_});
    const bool twice = std::any_of(settings_.begin(), settings_.end() - 1,
                                   [&](const Setting& other) { return other.name == name; });
    return !twice || refuse("it stands here a second time");
  }
  bool end_object() override {
    --depth_;
    return true;
  }
  bool start_array(std::size_t) override {
    const bool good = depth_ == 1;
    ++depth_;
    return good || refuse("a list within a list is no value");
  }
  bool end_array() override { return end_object(); }
  bool parse_error(std::size_t, const std::string&,
                   const nlohmann::detail::exception& error) override {
    const std::string what = error.what();
    const std::size_t place = what.find("syntax error");
    mistakes_.push_back(file_ + ":" + std::to_string(line_) + ": " +
                        (place == std::string::npos ? "this is no JSON" : what.substr(place)));
    return false;
  }

 private:
  bool add(std::string text) {
    if (settings_.empty()) return refuse("settings are one object, {\"name\": value, ...}");
    if (!wrong_) settings_.back().values.push_back(std::move(text));
    return true;
  }
  /// One mistake for each setting; false only where nothing that follows would make sense.
  bool refuse(const char* what) {
    if (settings_.empty()) {
      mistakes_.push_back(file_ + ":" + std::to_string(line_) + ": " +
                          "settings are one object, {\"name\": value, ...}");
      return false;
    }
    if (!wrong_) mistakes_.push_back(place_of(file_, settings_.back()) + what);
    wrong_ = true;
    settings_.back().values.clear();
    return true;
  }

  const std::string& file_;
  const int& line_;
  std::vector<std::string>& mistakes_;
  std::vector<Setting> settings_;
  int depth_ = 0;
  bool wrong_ = false;  ///< whether the last setting has its mistake
};

}  // namespace

std::vector<Setting> read_config(const std::string& file, std::vector<std::string>& mistakes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    mistakes.push_back(file + ": it is no file");
    return {};
  }
  const auto text = read_small_file(file, kMostBytes, "read the settings");
  if (!text) {
    mistakes.push_back(file + ": " + text.error().message);
    return {};
  }
  return parse_config(*text, file, mistakes);
}

std::vector<Setting> parse_config(std::string_view text, const std::string& file,
                                  std::vector<std::string>& mistakes) {
  int line = 1;
  Reader reader(file, line, mistakes);
  const char* begin = text.data();
  const char* end = begin + text.size();
  Json::sax_parse(CountingBytes{begin, &line}, CountingBytes{end, &line}, &reader,
                  Json::input_format_t::json, true, true);
  auto settings = std::move(reader).take();
  // Those without a value have said what is wrong with them, or are an empty list.
  std::erase_if(settings, [](const Setting& setting) { return setting.values.empty(); });
  return settings;
}

std::string place_of(const std::string& file, const Setting& setting) {
  return file + ":" + std::to_string(setting.line) + ": " + setting.name + ": ";
}

void append_flags(const Setting& setting, std::vector<std::string>& arguments) {
  for (const std::string& value : setting.values) {
    arguments.push_back("--" + setting.name + "=" + value);
  }
}

}  // namespace sightline
