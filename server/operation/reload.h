#pragma once
/// Changes a running server on SIGHUP: keys, and the settings that are Live.

#include "server/access/access.h"
#include "server/http/http_server.h"
#include "server/operation/cli.h"
#include "server/operation/log.h"
#include "server/service/service.h"

namespace sightline {

/// Reads a file of keys and puts it in force. Logs the number of keys and warnings about the file's
/// permissions. Errors: those of KeyRing::read; the old keys then stay in force.
Status take_keys(const std::string& file, AccessRules& access, Log& log);

/// The parts of a running server that reload() changes.
struct Running {
  ServeCommand& command;  ///< the settings in force
  AccessRules& access;
  Service& service;
  HttpServer& server;
  Log& log;
};
/// Reads the files of --keys and --config again. Logs what has changed, and which changes need a
/// restart. If one of the files is invalid, logs why, and what it set before stays in force. For
/// the thread that waits for signals; requests may run meanwhile.
void reload(const Running& running);

}  // namespace sightline

// Tests: tests/integration/settings_test.py
