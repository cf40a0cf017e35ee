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

/// Values of flags as given, which finish_serve converts.
struct ServeFlags {
  std::string listen = "127.0.0.1:8080";
  std::string skip = "all";
  std::string log_format = "text";
  std::vector<std::string> preloads, allow_urls, allow_addresses;
  double fetch_seconds = 300, origin_seconds = 5;
  double drain_seconds = 30, notice_seconds = 0, request_seconds = 60;
  HttpSeconds http;
};

/// Adds the flags to `app`; parsing sets `command` and `flags`, which must outlive `app`.
void define_serve(CLI::App& app, ServeCommand& command, ServeFlags& flags);
/// Converts the values of `flags` into members of `command` and checks each flag alone. To be
/// called once, after parsing. Throws CLI::ValidationError.
void finish_serve(ServeCommand& command, const ServeFlags& flags);
/// Checks combinations of flags: without --keys, only a loopback address or --insecure is accepted.
/// Throws CLI::ValidationError.
void check_together(const ServeCommand& command);
/// Warnings about settings that a server accepts, each "--flag: text".
std::vector<std::string> warnings_of(const ServeCommand& command);
/// All flags of a parsed `app`, with their values.
std::vector<FlagText> flag_texts(const CLI::App& app);

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
