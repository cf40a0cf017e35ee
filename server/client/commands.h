#pragma once
/// The commands that ask questions about rays. Each prints its answer on `out` and errors on
/// `complaints`, and returns the exit code.

#include <istream>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// sightline cast: traces one ray, without a server. Prints the hit as a line of JSON, or the
/// answer of the chosen mode. Returns 0 for a hit, 1 for a miss, 2 for an error.
int run_cast(const CastCommand& command, std::ostream& out, std::ostream& complaints);
/// sightline query: asks a server. Prints a line for each ray, in order. Returns 0; 1 if the single
/// ray of the command line misses; 2 for an error.
int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints);
/// sightline mcp: a server of the Model Context Protocol, by which an agent can use a Sightline
/// server. Answers each line of JSON-RPC 2.0 with a line, until the input ends. Returns 0, or 2 for
/// an error.
int run_mcp(const McpCommand& command, std::istream& in, std::ostream& out,
            std::ostream& complaints);

}  // namespace sightline
