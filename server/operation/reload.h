#pragma once
/// What can change while a server runs: keys, and the settings that are Live.

#include "server/access/access.h"
#include "server/http/http_server.h"
#include "server/operation/cli.h"
#include "server/operation/log.h"
#include "server/service/service.h"

namespace sightline {

/// Loads the keys of a file, and logs their number and what is wrong with the file's permissions.
/// Errors: those of KeyRing::read; the old keys then stay in force.
Status take_keys(const std::string& file, AccessRules& access, Log& log);

struct Running {
  ServeCommand& command;  ///< what is in force
  AccessRules& access;
  Service& service;
  HttpServer& server;
  Log& log;
};
/// Reads the files of --keys and --config again, and says in the log what has changed, and what
/// would need a new start. A file that is bad leaves in force what was, each for itself.
void reload(const Running& running);

}  // namespace sightline
