#pragma once
/// sightline serve: everything that a server is made of, put together.

#include <functional>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Ends the process with that exit code, whatever else is going on in it.
using EndNow = std::function<void(int code)>;

/// Serves until SIGTERM or SIGINT; a second one breaks off what the first one lets finish, and one
/// that comes while everything is taken down ends the process at once, as that signal does, or by
/// `end_now` where no signal can (in a container). The first line on `out` is "listening on
/// http://ADDR:PORT", as soon as connections are accepted; the log goes to standard error. Returns
/// the exit code: 0 after a stop, 2 when it could not start. Call from the first thread, before any
/// other is made.
int run_serve(const ServeCommand& command, const EndNow& end_now, std::ostream& out,
              std::ostream& complaints);

}  // namespace sightline
