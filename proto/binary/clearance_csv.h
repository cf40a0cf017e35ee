#pragma once
/// Encodes the answer to a question about clearance as CSV.

#include <string>

#include "proto/json/clearance_json.h"

namespace sightline {

/// Encodes pairs as CSV: a line of names, and a line for each pair. "distance" (with kinds "kind"
/// and "depth" before it), then the fields of both ends as "a.node_id" and "b.node_id". A position
/// has three columns, "a.position_x" and so on. A value that JSON has as null is empty.
std::string encode_clearance_csv(const ClearanceAnswer& answer, const ClearanceQuestion& question,
                                 FieldSet fields, const ClearanceEnds& a, const ClearanceEnds& b);

}  // namespace sightline

// Tests: tests/integration/clearance_test.py
