#pragma once
/// The file of --config: settings as JSON, of which each is a flag.

#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// "max-rays": 1000 is --max-rays 1000; true is a flag without a value, a list one for each value.
struct Setting {
  std::string name;
  std::vector<std::string> values;  ///< as they would be written after the flag
  int line = 0;
};

/// One object, comments as in C++ allowed. `mistakes` gets, each with its place: what is no JSON,
/// settings that stand twice, and values that no flag could have.
std::vector<Setting> read_config(const std::string& file, std::vector<std::string>& mistakes);

/// Parses `text`, the content of `file`.
std::vector<Setting> parse_config(std::string_view text, const std::string& file,
                                  std::vector<std::string>& mistakes);

/// "FILE:LINE: name: "
std::string place_of(const std::string& file, const Setting& setting);

void append_flags(const Setting& setting, std::vector<std::string>& arguments);

}  // namespace sightline
