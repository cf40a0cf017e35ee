#pragma once
/// The commands that ask questions about rays. Each prints its answer on `out` and errors on
/// `complaints`, and returns the exit code.

#include <istream>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

// cast and query have the same flags of rays, modes, fields and formats, and print the answers of
// rays in order. Both return 0; 1 if the single ray of the command line misses; 2 for an error.

/// sightline cast: traces rays through a file, without a server.
int run_cast(const CastCommand& command, std::istream& in, std::ostream& out,
             std::ostream& complaints);
/// sightline query: asks a server.
int run_query(const QueryCommand& command, std::istream& in, std::ostream& out,
              std::ostream& complaints);
/// sightline mcp: a server of the Model Context Protocol, by which an agent can use a Sightline
/// server. Answers each line of JSON-RPC 2.0 with a line, until the input ends. Returns 0, or 2 for
/// an error.
int run_mcp(const McpCommand& command, std::istream& in, std::ostream& out,
            std::ostream& complaints);

}  // namespace sightline

// Tests: tests/integration/cast_test.py
