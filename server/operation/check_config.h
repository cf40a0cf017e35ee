#pragma once
/// sightline check-config: whether a server would take a file of settings.

#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Prints each mistake and each warning with its place on `complaints`. Returns the exit code: 0
/// or 2.
int run_check(const CheckCommand& command, std::ostream& out, std::ostream& complaints);

}  // namespace sightline
