#pragma once
/// sightline demo: a demo scene as a file.

#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Returns the exit code: 0, or 2 for an error.
int run_demo(const DemoCommand& command, std::ostream& complaints);

}  // namespace sightline
