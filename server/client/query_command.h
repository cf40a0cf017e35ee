#pragma once
/// sightline query: the command line as a client of a server.

#include <istream>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Prints a line for each ray, in their order. Returns the exit code: 0; 1 where the only ray of
/// the command line misses; 2 after a line on `complaints`.
int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints);

}  // namespace sightline
