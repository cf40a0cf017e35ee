// The files of --keys and --config: what is wrong with them, or keys and settings.
// Run:  scripts/stress.sh fuzz --target settings_fuzz
//
// The first byte of an input says which of the two follows.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/key_ring.h"
#include "server/operation/config_file.h"
#include "tests/fuzz/promise.h"

using namespace sightline;

namespace {

using fuzz::require;

void check_keys(std::string_view text) {
  const auto ring = KeyRing::parse(text);
  if (!ring) {
    require(ring.error().code == "KEYS_INVALID" && ring.error().message.size() < 200,
            "errors do not show what might be a key");
    return;
  }
  require(ring->size() <= 1000, "limits hold");
  require(ring->find("") == nullptr, "nothing is no key");
  // Nobody finds a text whose hash is one that stands here.
  require(ring->find(text) == nullptr, "what is stored opens nothing");
}

void check_settings(std::string_view text) {
  std::vector<std::string> mistakes;
  const auto settings = parse_config(text, "file", mistakes);
  const auto document = nlohmann::json::parse(text, nullptr, false, true);
  for (const std::string& mistake : mistakes) {
    require(mistake.starts_with("file:"), "mistakes have a place");
  }
  for (const Setting& setting : settings) {
    require(!setting.values.empty() && setting.line > 0, "settings have values and a line");
    std::vector<std::string> flags;
    append_flags(setting, flags);
    require(flags.size() == setting.values.size(), "each value is a flag");
    for (const std::string& flag : flags) {
      require(flag.find('\0', 2 + setting.name.size()) == std::string::npos, "no value has a NUL");
    }
  }
  if (!mistakes.empty()) return;
  require(document.is_object(), "what has no mistake is one object");
  for (const Setting& setting : settings) {
    require(document.contains(setting.name), "settings stand in the file");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) {
    check_keys(text);
  } else {
    check_settings(text);
  }
  return 0;
}
