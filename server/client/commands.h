#pragma once
/// The commands that ask about rays. Each prints its answer on `out` and faults on `complaints`,
/// and returns the exit code.

#include <istream>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// sightline cast: one ray, without a server. Prints the hit as one line of JSON, or what the mode
/// asks for. 0 for a hit, 1 for a miss, 2 for an error.
int run_cast(const CastCommand& command, std::ostream& out, std::ostream& complaints);
/// sightline query: a client of a server. Prints a line for each ray, in their order. 0; 1 where
/// the only ray of the command line misses; 2 for an error.
int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints);
/// sightline mcp: a server of the Model Context Protocol, through which an agent asks a server of
/// Sightline. Answers a line of JSON-RPC 2.0 with a line, until the input ends. 0, or 2 for an
/// error.
int run_mcp(const McpCommand& command, std::istream& in, std::ostream& out,
            std::ostream& complaints);

}  // namespace sightline
