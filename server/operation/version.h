#pragma once
/// The version of the program.

#include <string>

namespace sightline {

/// For example "0.1.0".
std::string version();
/// A text for people: the version, and the kernels that this machine can run, fastest first.
std::string version_text();

}  // namespace sightline

// Tests: tests/unit/server/cli_test.cpp
