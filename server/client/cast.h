#pragma once
/// sightline cast: one ray, without a server.

#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Prints the hit as one line of JSON on `out` (or what the mode asks for), faults on `complaints`.
/// Returns the exit code: 0 for a hit, 1 for a miss, 2 for an error.
int run_cast(const CastCommand& command, std::ostream& out, std::ostream& complaints);

}  // namespace sightline
