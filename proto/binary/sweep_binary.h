#pragma once
/// Decodes sweeps from bytes: docs/reference/binary.md.

#include <string_view>

#include "proto/json/sweep_json.h"

namespace sightline {

/// Decodes a body of sweeps, all of one shape. float32 numbers are converted to
/// float64 without error. The fields are not checked for text. Errors: 400 BINARY_MALFORMED, 413
/// SWEEPS_TOO_MANY, and those of decode_sweeps.
Result<SweepQuery> decode_sweeps_binary(std::string_view body, const SweepJsonRules& rules);

}  // namespace sightline

// Tests: tests/integration/sweeps_test.py
