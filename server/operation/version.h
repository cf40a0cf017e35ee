#pragma once
/// Name, version and limits of the program.

#include <string>

namespace sightline {

/// "0.1.0"
std::string version();
/// For people: the version, and the kernels that this machine can run, best first.
std::string version_text();

}  // namespace sightline
