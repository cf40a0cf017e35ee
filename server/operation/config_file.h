#pragma once
/// Reads the file of --config: settings as JSON, each with the name of a flag.

#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// A setting. "max-rays": 1000 is --max-rays 1000; true is a flag without a value; a list is a flag
/// given several times.
struct Setting {
  std::string name;
  std::vector<std::string> values;  ///< as they would follow the flag on the command line
  int line = 0;                     ///< of its name, from 1
};

/// Reads a file with a JSON object, in which C++ comments are allowed. Appends to `mistakes`, each
/// with its place: a file that cannot be read, text that is not JSON, settings given twice, and
/// values that no flag can have. Returns the settings without a mistake; names are not checked.
std::vector<Setting> read_config(const std::string& file, std::vector<std::string>& mistakes);

/// Parses `text`, the content of `file`; otherwise like read_config. `file` is used for messages.
std::vector<Setting> parse_config(std::string_view text, const std::string& file,
                                  std::vector<std::string>& mistakes);

/// The place of a setting for messages: "FILE:LINE: name: ".
std::string place_of(const std::string& file, const Setting& setting);

/// Appends "--NAME=VALUE" to `arguments` for each value of a setting.
void append_flags(const Setting& setting, std::vector<std::string>& arguments);

}  // namespace sightline
