#pragma once
/// The command line: what was asked for, as plain data.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/query/hit_batch.h"
#include "core/query/ray_batch.h"
#include "proto/hit_fields.h"
#include "server/access/key_ring.h"
#include "server/http/http_limits.h"
#include "server/http/http_server.h"
#include "server/operation/log.h"
#include "server/service/scene_source.h"
#include "server/service/service.h"
#include "server/sources/url_fetch.h"

namespace sightline {

/// One flag of sightline serve, without its dashes, as it was given, or else its default.
struct FlagText {
  std::string name, text;
  bool live = false;  ///< whether SIGHUP changes it
  bool operator==(const FlagText&) const = default;
};

/// sightline serve
struct ServeCommand {
  std::string config;  ///< a file of settings; they stand in this already
  ListenAddress listen{"127.0.0.1", 8080};
  std::string keys;       ///< a file; empty: everybody may do everything
  bool insecure = false;  ///< without keys where others than this machine can ask
  std::string data;       ///< empty: scenes live in memory only
  std::vector<std::pair<std::string, std::string>> preloads;  ///< id, source
  int threads = 0;
  std::vector<std::string> cors_origins;  ///< whose pages may ask
  std::string scene_root;                 ///< empty: clients may name no paths
  UrlRules urls;
  std::string kernel;
  std::string log_level = "info";
  LogFormat log_format = LogFormat::kText;
  HttpLimits http;
  ServiceLimits limits;
  Laziness laziness = Laziness::kWhenNeeded;
  std::vector<FlagText> flags;         ///< all
  std::vector<std::string> arguments;  ///< to parse again
};

/// The question of `sightline cast` and `query` about a ray.
enum class CastMode { kClosest, kAny, kAll, kCount };

/// sightline cast
struct CastCommand {
  std::string source;
  Ray ray;
  CastMode mode = CastMode::kClosest;
  Crossings crossings = Crossings::kEvery;
  std::optional<std::uint32_t> scene;
  FieldSet fields = kDefaultHitFields;
  std::string kernel;
};

/// The server that a client talks to, and the key that it sends.
struct ServerAddress {
  std::string url;
  std::string key_file;  ///< empty: the key is in the environment, if there is one
};

/// sightline query
struct QueryCommand {
  ServerAddress server;
  std::string scene;
  std::string rays;  ///< a file, "-": standard input; empty: `ray`
  Ray ray;
  CastMode mode = CastMode::kClosest;
  Crossings crossings = Crossings::kEvery;
  std::optional<FieldSet> fields;
  bool json = false;
};

/// sightline mcp
struct McpCommand {
  ServerAddress server;
  std::string files;  ///< a folder; empty: nothing can be uploaded
};

/// sightline demo
struct DemoCommand {
  std::string name;
  std::string file;
};

/// sightline key new
struct KeyCommand {
  Access access = Access::kRead;
  std::string name;
};

/// sightline check-config
struct CheckCommand {
  std::string file;
};

/// Nothing to run: what was asked for is this text.
struct ShowText {
  std::string text;
  int exit_code = 0;
};

using Command = std::variant<ServeCommand, CastCommand, QueryCommand, McpCommand, DemoCommand,
                             KeyCommand, CheckCommand, ShowText>;

/// `arguments` begin with the name of the program. Reads the file of --config.
Command parse_command_line(const std::vector<std::string>& arguments);
/// Parses the arguments again for a running server. Its file of keys is read separately and may be
/// missing.
Command parse_again(const std::vector<std::string>& arguments);

/// The mistakes in a file for --config, each with its place, "FILE:LINE: name: text".
struct ConfigReport {
  std::vector<std::string> mistakes;  ///< none: a server would take it
  std::vector<std::string> warnings;
};
ConfigReport report_of_config(const std::string& file);

}  // namespace sightline
