#pragma once
/// Decodes sweeps from bytes: docs/reference/binary.md.

#include <string_view>

#include "proto/json/sweep_json.h"

namespace sightline {

/// Decodes a body of sweeps. Errors: those of decode_rays_binary and decode_sweeps.
Result<SweepQuery> decode_sweeps_binary(std::string_view body, const SweepJsonRules& rules);

}  // namespace sightline

// Tests: tests/integration/sweeps_test.py
