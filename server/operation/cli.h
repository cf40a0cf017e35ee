#pragma once
/// Parses the command line into plain data: one struct for each command.

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

/// A flag of sightline serve, with its value as given on the command line, in the file of --config,
/// or by default. The name has no dashes.
struct FlagText {
  std::string name, text;
  bool live = false;  ///< SIGHUP can change it
  bool operator==(const FlagText&) const = default;
};

/// sightline serve. Here and in the other commands, a member without a comment is the flag of its
/// name.
struct ServeCommand {
  std::string config;  ///< file of settings; the members contain them already
  ListenAddress listen{"127.0.0.1", 8080};
  std::string keys;                ///< file of keys; empty: every client may do everything
  bool insecure = false;           ///< starts without keys even if other machines can connect
  std::string data;                ///< data folder; empty: scenes are in memory only
  std::string origin;              ///< folder or s3://BUCKET/PREFIX that servers share; empty: none
  std::string origin_credentials;  ///< file; empty: they are in the environment
  std::chrono::milliseconds origin_refresh{5'000};
  std::uint64_t cache_bytes = 0;                              ///< 0: no limit
  std::vector<std::pair<std::string, std::string>> preloads;  ///< pairs of scene name and source
  int threads = 0;                        ///< threads that trace rays; 0: one for each processor
  std::vector<std::string> cors_origins;  ///< origins whose pages may read answers
  std::string scene_root;  ///< folder of scene files; empty: clients may name no paths
  UrlRules urls;
  std::string kernel;
  std::string log_level = "info";
  LogFormat log_format = LogFormat::kText;
  HttpLimits http;
  ServiceLimits limits;
  Laziness laziness = Laziness::kWhenNeeded;
  std::vector<FlagText> flags;         ///< all flags, to find out what SIGHUP changes
  std::vector<std::string> arguments;  ///< to be parsed again after SIGHUP
};

/// What `sightline cast` and `query` ask about a ray.
enum class CastMode { kClosest, kAny, kAll, kCount };

/// How the commands cast and query print answers.
enum class PrintFormat {
  kText,  ///< for people
  kJson,  ///< a line of JSON for each ray, as rays:* of a server answers with lines
  kHits,  ///< a line of JSON for each hit; otherwise like kJson
};

/// What the commands cast and query have in common.
struct RayQuestion {
  std::string rays;  ///< a file of rays; "-": standard input; empty: `ray`
  Ray ray;
  CastMode mode = CastMode::kClosest;
  Crossings crossings = Crossings::kEvery;
  std::optional<FieldSet> fields;
  std::vector<std::string> named_fields;  ///< what kNamed of `fields` stands for
  PrintFormat format = PrintFormat::kText;
};

/// sightline cast
struct CastCommand : RayQuestion {
  std::string source;
  std::optional<std::uint32_t> scene;
  std::string kernel;
};

/// The server that a client connects to, and its key.
struct ServerAddress {
  std::string url;
  std::string key_file;  ///< empty: the key is in the environment, if there is one
};

/// sightline query
struct QueryCommand : RayQuestion {
  ServerAddress server;
  std::string scene;
};

/// sightline mcp
struct McpCommand {
  ServerAddress server;
  std::string files;                     ///< folder of files that may be uploaded; empty: none
  std::size_t max_answer_bytes = 32768;  ///< a longer answer becomes a summary and pages
};

/// sightline demo
struct DemoCommand {
  std::string name;
  std::string file;
};

/// sightline convert
struct ConvertCommand {
  std::string from, to;
  std::uint64_t memory_mib = 4096;  ///< the most memory and output of the converter
  std::uint64_t seconds = 300;      ///< the most processor time; twice as much time in total
};

/// `sightline key new`: prints a new API key, and the line for the file of --keys that accepts it.
struct KeyCommand {
  Access access = Access::kRead;  ///< what the key allows
  std::string name;               ///< written into the line, to recognise the key in the log
};

/// sightline check-config
struct CheckCommand {
  std::string file;
};

/// Nothing to run: print this text (help, version, or an error), and exit with `exit_code`.
struct ShowText {
  std::string text;
  int exit_code = 0;
};

using Command = std::variant<ServeCommand, CastCommand, QueryCommand, McpCommand, DemoCommand,
                             KeyCommand, CheckCommand, ConvertCommand, ShowText>;

/// Parses the arguments, of which the first is the name of the program. Reads the file of --config;
/// flags take precedence over it. Returns ShowText for help and for mistakes. Throws nothing for
/// mistakes of the user.
Command parse_command_line(const std::vector<std::string>& arguments);
/// Parses the arguments again in a running server, after SIGHUP. Does not check the file of keys,
/// which is read separately and may be missing.
Command parse_again(const std::vector<std::string>& arguments);

/// The result of checking a file for --config. Each entry is "FILE:LINE: name: text".
struct ConfigReport {
  std::vector<std::string> mistakes;  ///< empty: a server would accept the file
  std::vector<std::string> warnings;
};
/// Checks a file for --config and all that it names: keys, folders, and combinations of flags.
/// Changes nothing.
ConfigReport report_of_config(const std::string& file);

}  // namespace sightline
