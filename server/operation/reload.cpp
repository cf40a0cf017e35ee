#include "server/operation/reload.h"

#include <filesystem>
#include <sstream>

#include "server/operation/system_limits.h"

namespace sightline {
namespace {

/// Each line for itself, and of the file's path the name alone.
void log_refusal(const ServeCommand& command, const std::string& text, Log& log) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    const std::size_t place = line.find(command.config);
    if (place != std::string::npos) {
      line.replace(place, command.config.size(),
                   std::filesystem::path(command.config).filename().string());
    }
    // What a terminal would be told beside it.
    constexpr std::string_view kProgram = "sightline: ";
    if (line.starts_with("See sightline")) continue;
    if (line.starts_with(kProgram)) line.erase(0, kProgram.size());
    log.error(line);
  }
  log.error("the settings stay as they were");
}

void take_settings(const Running& running, const ServeCommand& next) {
  ServeCommand& command = running.command;
  Service& service = running.service;
  for (std::size_t i = 0; i < next.flags.size() && i < command.flags.size(); ++i) {
    const FlagText& flag = next.flags[i];
    if (flag == command.flags[i]) continue;
    if (flag.live) {
      running.log.info("setting changed", {{"name", flag.name}, {"value", flag.text}});
      command.flags[i] = flag;
    } else {
      running.log.warn("setting waits for the next start", {{"name", flag.name}});
    }
  }
  command.limits.take_live(next.limits);
  command.http.take_live(next.http);
  command.http.connections = allowed_connections(command.http);
  command.log_level = next.log_level;
  service.limits.take_live(command.limits);
  running.server.change(command.http);
  running.log.set_level(command.log_level);
}

}  // namespace

Status take_keys(const std::string& file, AccessRules& access, Log& log) {
  std::vector<std::string> warnings;
  auto ring = KeyRing::read(file, warnings);
  if (!ring) return std::move(ring).error();
  for (const std::string& warning : warnings) log.warn(warning);
  log.info("keys taken", {{"count", std::uint64_t{ring->size()}}});
  access.use(std::move(*ring));
  return success();
}

void reload(const Running& running) {
  const ServeCommand& command = running.command;
  Log& log = running.log;
  log.info("reloading");
  // First, and whatever the settings are: a key that was taken away is not to wait for them.
  bool has_keys = true, has_settings = true;
  if (!command.keys.empty()) {
    if (const Status taken = take_keys(command.keys, running.access, log); !taken) {
      log.error("the keys stay as they were", {{"reason", taken.error().message}});
      has_keys = false;
    }
  }
  const Command next = parse_again(command.arguments);
  if (const auto* serve = std::get_if<ServeCommand>(&next)) {
    take_settings(running, *serve);
  } else if (const auto* shown = std::get_if<ShowText>(&next)) {
    log_refusal(command, shown->text, log);
    has_settings = false;
  }
  log.info(has_settings ? (has_keys ? "reloaded" : "reloaded, keys unchanged")
                        : (has_keys ? "reloaded, settings unchanged"
                                    : "reloaded, keys and settings unchanged"));
}

}  // namespace sightline
