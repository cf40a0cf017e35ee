#pragma once
/// Limits of the operating system for this process.

#include <cstddef>
#include <cstdint>

#include "server/http/http_limits.h"

namespace sightline {

/// Raises the process's soft limit of open files if needed and allowed. Returns how many
/// connections fit below it, with room for other files: at most `limits.connections`; else at least
/// 16.
std::size_t allowed_connections(const HttpLimits& limits);

/// Bytes of memory of the machine, or of its container.
std::uint64_t machine_memory();

}  // namespace sightline

// Tests: tests/integration/abuse_test.py
