#pragma once
/// One hit as JSON. For files of this room only.

#include "proto/hit_columns.h"
#include "proto/json/json_writer.h"

namespace sightline {

/// {"t":5,"triangle":12}, or null.
void write_row(JsonWriter& out, const HitAnswer& answer, FieldSet fields, std::size_t i);
/// A guess at the bytes of one hit: 18 for each number, 12 for the rest.
std::size_t expected_hit_bytes(FieldSet fields);

}  // namespace sightline

// Tests: tests/unit/proto/hit_json_test.cpp
