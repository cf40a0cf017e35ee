#pragma once
/// Limits that the operating system sets for a process.

#include <cstddef>
#include <cstdint>

#include "server/http/http_limits.h"

namespace sightline {

/// Raises the soft limit of open files as far as it is needed and may be, and returns how many
/// connections fit below it, with room left for files: at most `limits.connections`, at least 16.
std::size_t allowed_connections(const HttpLimits& limits);

/// Bytes of memory that the machine has, or that its container may use.
std::uint64_t machine_memory();

}  // namespace sightline
