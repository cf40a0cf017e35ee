#pragma once
/// sightline key: makes the keys that clients show.

#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Prints "key: ..." and "line: ..." and stores neither. Returns the exit code: 0, or 2 for an
/// error.
int run_key(const KeyCommand& command, std::ostream& out, std::ostream& complaints);

}  // namespace sightline
