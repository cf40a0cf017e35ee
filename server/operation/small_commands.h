#pragma once
/// The small commands: sightline demo, key, convert and check-config. Each returns the exit code:
/// 0, or 2 for an error.

#include <ostream>

#include "server/operation/cli.h"

namespace sightline {

/// Writes a demo scene to a file as GLB; replaces a file of that name.
int run_demo(const DemoCommand& command, std::ostream& complaints);
/// Makes a key for a client. Prints "key: ..." and "line: ...", and stores neither.
int run_key(const KeyCommand& command, std::ostream& out, std::ostream& complaints);
/// Replaces this process by sightline-convert, which is beside its program. Returns only if there is
/// none.
int run_convert(const ConvertCommand& command, std::ostream& complaints);
/// Checks whether a server would accept a file of settings. Prints each mistake and warning with
/// its place on `complaints`, and "FILE: good" on `out` if there is no mistake.
int run_check(const CheckCommand& command, std::ostream& out, std::ostream& complaints);

}  // namespace sightline

// Tests: tests/integration/settings_test.py
