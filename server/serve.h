#pragma once
/// sightline serve: everything that a server is made of, put together.

#include <ostream>

#include "server/cli.h"

namespace sightline {

/// Serves until SIGTERM or SIGINT; a second one breaks off what the first one lets finish, and one
/// that comes while everything is taken down ends the process at once, as that signal does. The
/// first line on `out` is "listening on http://ADDR:PORT", as soon as connections are accepted; the
/// log goes to standard error. Returns the exit code: 0 after a stop, 2 when it could not start.
/// Call from the first thread, before any other is made.
int run_serve(const ServeCommand& command, std::ostream& out, std::ostream& complaints);

}  // namespace sightline
