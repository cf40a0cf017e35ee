#pragma once
/// The flags of sightline serve.

#include <string>
#include <vector>

#include "server/operation/cli.h"
#include "server/operation/http_flags.h"

namespace CLI {
class App;
}

namespace sightline {

/// Flags as they are written, and what becomes of them after the parse.
struct ServeFlags {
  std::string listen = "127.0.0.1:8080";
  std::string skip = "all";
  std::string log_format = "text";
  std::vector<std::string> preloads, allow_urls, allow_addresses;
  double fetch_seconds = 300;
  double drain_seconds = 30, notice_seconds = 0, request_seconds = 60;
  HttpSeconds http;
};

void define_serve(CLI::App& app, ServeCommand& command, ServeFlags& flags);
/// Converts the texts of the flags into members of `command` and checks each flag alone. Call it
/// once, after parsing. Throws CLI::ValidationError.
void finish_serve(ServeCommand& command, const ServeFlags& flags);
/// Checks combinations of flags, after each flag was parsed. Throws CLI::ValidationError.
void check_together(const ServeCommand& command);
/// Warnings for the operator about settings that a server accepts, each "--flag: text".
std::vector<std::string> warnings_of(const ServeCommand& command);
/// Every flag of a parsed `app`.
std::vector<FlagText> flag_texts(const CLI::App& app);

}  // namespace sightline
