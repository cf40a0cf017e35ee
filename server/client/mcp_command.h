#pragma once
/// sightline mcp: a server of the Model Context Protocol on standard input and output, through
/// which an agent asks a server of Sightline.

#include <istream>
#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Answers a line of JSON-RPC 2.0 with a line, until the input ends. Returns the exit code: 0, or
/// 2 after a line on `complaints`.
int run_mcp(const McpCommand& command, std::istream& in, std::ostream& out,
            std::ostream& complaints);

}  // namespace sightline
