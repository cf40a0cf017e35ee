#pragma once
/// Sweeps as bytes: docs/reference/binary.md has the table.

#include <string_view>

#include "proto/json/sweep_json.h"

namespace sightline {

/// Errors: as decode_rays_binary and decode_sweeps.
Result<SweepQuery> decode_sweeps_binary(std::string_view body, const SweepJsonRules& rules);

}  // namespace sightline

// Tests: tests/integration/sweeps_test.py
